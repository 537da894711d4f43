// Inserts a job's row within the caller's transaction.
#pragma once

#include "storage/job_store.h"
#include "storage/postgres/connection.h"

namespace freelsd {

void InsertJob(PostgresConnection& writer, const JobRow& job);

}  // namespace freelsd
