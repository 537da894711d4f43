#include "api/export/geotiff_tags.h"

#include <memory>
#include <stdexcept>

#include <geotiff/geotiff.h>
#include <geotiff/geotiffio.h>

namespace freelsd {
namespace {

// Tag 42113 of GDAL: the value that means "no data", as text.
constexpr ttag_t kNoDataTag = 42113;
// libtiff keeps the pointer to the name.
char no_data_name[] = "GDALNoDataValue";

struct GeoKeysFreer {
  void operator()(GTIF* keys) const { GTIFFree(keys); }
};

}  // namespace

void WriteGeoKeys(TIFF* tiff, int epsg) {
  const std::unique_ptr<GTIF, GeoKeysFreer> keys(GTIFNew(tiff));
  if (!keys) throw std::runtime_error("GeoTIFF: keys cannot be written");
  GTIFKeySet(keys.get(), GTModelTypeGeoKey, TYPE_SHORT, 1, ModelTypeProjected);
  GTIFKeySet(keys.get(), GTRasterTypeGeoKey, TYPE_SHORT, 1, RasterPixelIsArea);
  GTIFKeySet(keys.get(), ProjectedCSTypeGeoKey, TYPE_SHORT, 1, epsg);
  GTIFKeySet(keys.get(), ProjLinearUnitsGeoKey, TYPE_SHORT, 1, Linear_Meter);
  GTIFWriteKeys(keys.get());
}

void WriteNoDataTag(TIFF* tiff) {
  const TIFFFieldInfo no_data{
      kNoDataTag, TIFF_VARIABLE, TIFF_VARIABLE, TIFF_ASCII, FIELD_CUSTOM, 1, 0, no_data_name};
  TIFFMergeFieldInfo(tiff, &no_data, 1);
  TIFFSetField(tiff, kNoDataTag, "nan");
}

}  // namespace freelsd
