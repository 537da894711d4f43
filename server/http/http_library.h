// Includes cpp-httplib, without the macro `_res` of <resolv.h>: Eigen uses that name.
#pragma once

#include <httplib.h>

#undef _res
