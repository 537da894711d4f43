// Inserts a job's row within the caller's transaction.
#pragma once

#include "storage/job_store.h"
#include "storage/sqlite/sqlite.h"

namespace freelsd {

void InsertJobRow(const Connection& writer, const JobRow& job);

}  // namespace freelsd
