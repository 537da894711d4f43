// The engine's threads, and the state that they share with the handlers.
#pragma once

#include "server/jobs/failure.h"
#include "server/jobs/heap.h"
#include "server/jobs/job_json.h"
#include "server/jobs/service.h"
#include "server/jobs/worker.h"
