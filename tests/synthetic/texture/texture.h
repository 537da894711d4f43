// Input: photographs of recorded ground. Output: the same ground without end, and worlds that wear
// it in place of painted noise.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "tests/synthetic/world.h"

namespace freelsd {

// A texture without end and without repetition that looks like one piece of a photograph. Pieces of
// the photograph are blended over a lattice of triangles, so that mean and deviation stay (Heitz
// and Neyret 2018, without their transform of the histogram). Slow changes of brightness over the
// whole piece (lens, light) are removed.
class RecordedTexture {
 public:
  // `piece`: BGR, at the scale of the world's cells. `edge_ratio`: of a triangle's edge to the
  // piece's narrower side. Longer edges keep rows together and show less of the piece: what is
  // within one edge of its border lies around no vertex. Throws std::invalid_argument if the piece
  // is narrower than 12 pixels.
  RecordedTexture(const cv::Mat3b& piece, uint64_t seed, double edge_ratio = 0.17);

  // BGR, 0..255, not rounded. Any cell of the plane.
  cv::Vec3f At(int col, int row) const;
  const cv::Vec3f& mean() const { return mean_; }

 private:
  // A pixel of the piece for a cell at an offset from a vertex of the lattice.
  cv::Vec3f PieceAt(int vertex_col, int vertex_row, int col, int row) const;

  cv::Mat3f piece_;  // less its mean
  cv::Vec3f mean_;
  uint64_t seed_;
  int edge_px_;  // of a triangle
};

// One row of sources.csv: even ground of one kind on one photograph.
struct TextureSource {
  std::string pool;  // "tuning" or "report": which worlds wear it
  Cover cover = Cover::kMeadow;
  std::string kind;                // "mown", "grazed", ...
  std::string photograph;          // path within $FREELSD_DATA
  double ground_sampling_m = 0.0;  // of the stored photograph
  cv::Rect area;                   // pixels of the stored photograph
  // "place" if no photograph of its place is in the other pool, else "photograph".
  std::string split;
};
// Rows of tests/synthetic/texture/sources.csv. Throws std::runtime_error that names the line.
std::vector<TextureSource> ReadTextureSources();

// The textures of a pool, at the scale of a world's cells. Covers without a source stay painted.
class Wardrobe {
 public:
  // Reads the photographs from $FREELSD_DATA. Throws std::runtime_error with what is missing.
  static Wardrobe Read(const std::string& pool, double cell_size_m);

  // Null where no photograph shows such ground. The variant of a field chooses among the sources.
  const RecordedTexture* For(Cover cover, uint8_t variant) const;

 private:
  std::vector<std::vector<RecordedTexture>> textures_ =
      std::vector<std::vector<RecordedTexture>>(kNumCovers);
};

// Clothes every cell whose cover has a source, and lights the world anew. Hue and contrast are the
// photograph's; the mean brightness of a field stays what it was, so that one exposure fits the
// whole world. Cells that show a photograph keep its colours, and get the texture's detail.
void Clothe(World& world, const Wardrobe& wardrobe);

}  // namespace freelsd
