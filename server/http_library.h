// cpp-httplib, without what it drags in: <resolv.h> makes `_res` a macro, and Eigen uses the name.
#pragma once

#include <httplib.h>

#undef _res
