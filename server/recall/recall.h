// Answers that need only stored sites: emergency recall, alternates, plans on stored maps.
#pragma once

#include "server/recall/alternates.h"
#include "server/recall/emergency_request.h"
#include "server/recall/flight_state.h"
#include "server/recall/map_cache.h"
#include "server/recall/map_place/map_place.h"
#include "server/recall/obstacles/obstacles.h"
#include "server/recall/reach/reach.h"
#include "server/recall/recall_candidates.h"
#include "server/recall/recall_sites.h"
#include "server/recall/replan.h"
#include "server/recall/route/route.h"
#include "server/recall/same_place.h"
#include "server/recall/standing.h"
#include "server/recall/superseding.h"
