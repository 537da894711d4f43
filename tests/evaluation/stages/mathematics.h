// What the functions of the C library give: they need not be correct in the last digit, so each
// processor's library may round in its own way.
#pragma once

#include "tests/evaluation/stages/stage_record.h"

namespace freelsd {

// One record for each function that the sources call, at the same random arguments on every
// processor.
StageRecords RunMathematics(int num_arguments);

}  // namespace freelsd
