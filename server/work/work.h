// The engine's threads, and the state that they share with the handlers.
#pragma once

#include "server/work/failure.h"
#include "server/work/heap.h"
#include "server/work/job_json.h"
#include "server/work/service.h"
#include "server/work/worker.h"
