// Intake checks images, frames, batches and telemetry, and stores them.
#pragma once

#include "server/intake/arrival_clock.h"
#include "server/intake/batch.h"
#include "server/intake/checked_image.h"
#include "server/intake/flight_datum.h"
#include "server/intake/frame_intake.h"
#include "server/intake/frame_resolution.h"
#include "server/intake/num_streams.h"
#include "server/intake/odd_photographs.h"
#include "server/intake/state.h"
#include "server/intake/stored_images.h"
#include "server/intake/telemetry.h"
#include "server/intake/warnings.h"
