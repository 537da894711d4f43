// HTTP functions that all URLs share: connections, requests, answers, events, tokens, metrics.
#pragma once

#include "server/http/body_reader.h"
#include "server/http/call.h"
#include "server/http/digest.h"
#include "server/http/events.h"
#include "server/http/http_library.h"
#include "server/http/http_server.h"
#include "server/http/lower_case.h"
#include "server/http/metrics.h"
#include "server/http/multipart.h"
#include "server/http/origin_check.h"
#include "server/http/page.h"
#include "server/http/priority.h"
#include "server/http/problem.h"
#include "server/http/request_head.h"
#include "server/http/stamps.h"
#include "server/http/tokens.h"
