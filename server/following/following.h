// Servers that follow each other: an edge keeps a copy of a centre's sites, maps and obstacles in
// step, recalls from it, and sends back what it has made itself.
#pragma once

#include "server/following/copy.h"
#include "server/following/feed.h"
#include "server/following/follower.h"
#include "server/following/merging.h"
#include "server/following/told_change.h"
#include "server/following/told_map.h"
