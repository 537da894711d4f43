// Private to export/. Tags that every GeoTIFF of this folder has.
#pragma once

#include <tiffio.h>

namespace freelsd {

// Coordinate system of the file. `tiff` is opened with XTIFFOpen or XTIFFClientOpen. Throws
// std::runtime_error if the keys cannot be written.
void WriteGeoKeys(TIFF* tiff, int epsg);
// NaN means "no data" in the current directory of the file.
void WriteNoDataTag(TIFF* tiff);

}  // namespace freelsd
