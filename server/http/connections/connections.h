// The connections of one listener, served by one poll loop.
#pragma once

#include "server/http/connections/connection_loop.h"
