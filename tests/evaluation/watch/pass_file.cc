#include "tests/evaluation/watch/pass_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <type_traits>

#include <opencv2/imgcodecs.hpp>

namespace freelsd {
namespace {

class Writer {
 public:
  explicit Writer(const std::string& file) : out_(file, std::ios::binary) {
    if (!out_) throw std::runtime_error("cannot write " + file);
  }

  template <typename T>
  void Value(const T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    out_.write(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void Bytes(const void* data, size_t size) {
    Value(size);
    out_.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
  }
  void Raster(const cv::Mat& raster) {
    const cv::Mat whole = raster.isContinuous() ? raster : raster.clone();
    Value(whole.rows), Value(whole.cols), Value(whole.type());
    Bytes(whole.data, whole.total() * whole.elemSize());
  }
  template <typename Vector>
  void Numbers(const Vector& numbers) {
    for (Eigen::Index i = 0; i < numbers.size(); ++i) Value(double{numbers.data()[i]});
  }
  void Of(const Grid& grid) {
    Numbers(grid.north_west_in_world);
    Value(grid.cell_size_m), Value(grid.num_rows), Value(grid.num_cols);
  }

 private:
  std::ofstream out_;
};

class Reader {
 public:
  explicit Reader(const std::string& file) : file_(file), in_(file, std::ios::binary) {
    if (!in_) throw std::runtime_error("cannot read " + file);
  }

  template <typename T>
  T Value() {
    T value{};
    in_.read(reinterpret_cast<char*>(&value), sizeof value);
    Check();
    return value;
  }
  std::vector<uchar> Bytes() {
    std::vector<uchar> bytes(Value<size_t>());
    in_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    Check();
    return bytes;
  }
  cv::Mat Raster() {
    const int rows = Value<int>(), cols = Value<int>(), type = Value<int>();
    std::vector<uchar> bytes = Bytes();
    return cv::Mat(rows, cols, type, bytes.data()).clone();
  }
  template <typename Vector>
  Vector Numbers() {
    Vector numbers;
    for (Eigen::Index i = 0; i < numbers.size(); ++i) numbers.data()[i] = Value<double>();
    return numbers;
  }
  Grid GridValue() {
    Grid grid;
    grid.north_west_in_world = Numbers<Eigen::Vector2d>();
    grid.cell_size_m = Value<double>();
    grid.num_rows = Value<int>(), grid.num_cols = Value<int>();
    return grid;
  }

 private:
  void Check() const {
    if (!in_) throw std::runtime_error(file_ + " ends early");
  }

  std::string file_;
  std::ifstream in_;
};

void WritePhoto(const PassPhoto& photo, Writer& writer) {
  const Camera& camera = photo.camera;
  writer.Bytes(photo.file.data(), photo.file.size());
  writer.Value(camera.width_px), writer.Value(camera.height_px);
  for (const double value : {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px}) {
    writer.Value(value);
  }
  writer.Numbers(photo.world_from_camera.rotation.coeffs());
  writer.Numbers(photo.world_from_camera.translation);
  writer.Value(photo.timestamp_us);
  writer.Value(photo.shown_things.size());
  for (const Eigen::Vector2d& thing : photo.shown_things) writer.Numbers(thing);
}

PassPhoto ReadPhoto(Reader& reader) {
  PassPhoto photo;
  photo.file = reader.Bytes();
  photo.camera.width_px = reader.Value<int>();
  photo.camera.height_px = reader.Value<int>();
  for (double* value :
       {&photo.camera.fx_px, &photo.camera.fy_px, &photo.camera.cx_px, &photo.camera.cy_px}) {
    *value = reader.Value<double>();
  }
  photo.world_from_camera.rotation.coeffs() = reader.Numbers<Eigen::Vector4d>();
  photo.world_from_camera.translation = reader.Numbers<Eigen::Vector3d>();
  photo.timestamp_us = reader.Value<int64_t>();
  photo.shown_things.resize(reader.Value<size_t>());
  for (Eigen::Vector2d& thing : photo.shown_things) thing = reader.Numbers<Eigen::Vector2d>();
  return photo;
}

}  // namespace

void WriteStrip(const StripPicture& strip, const std::string& file) {
  Writer writer(file);
  writer.Of(strip.grid);
  writer.Raster(strip.picture);
  writer.Of(strip.ground_grid);
  writer.Raster(strip.elevation);
  writer.Raster(strip.upper);
  writer.Value(strip.outlines.size());
  for (const Polygon& outline : strip.outlines) {
    writer.Value(outline.size());
    for (const Eigen::Vector2d& corner : outline) writer.Numbers(corner);
  }
}

StripPicture ReadStrip(const std::string& file) {
  Reader reader(file);
  StripPicture strip;
  strip.grid = reader.GridValue();
  strip.picture = reader.Raster();
  strip.ground_grid = reader.GridValue();
  strip.elevation = reader.Raster();
  strip.upper = reader.Raster();
  strip.outlines.resize(reader.Value<size_t>());
  for (Polygon& outline : strip.outlines) {
    outline.resize(reader.Value<size_t>());
    for (Eigen::Vector2d& corner : outline) corner = reader.Numbers<Eigen::Vector2d>();
  }
  return strip;
}

void WritePass(const RecordedPass& pass, const std::string& file) {
  Writer writer(file);
  writer.Bytes(pass.name.data(), pass.name.size());
  writer.Bytes(pass.strip_file.data(), pass.strip_file.size());
  writer.Value(pass.plan.seed), writer.Value(pass.plan.event), writer.Value(pass.plan.change);
  writer.Value(pass.plan.height_m), writer.Value(pass.plan.tilt_deg);
  writer.Value(pass.plan.noise_scale);
  writer.Value(pass.photos.size());
  for (const PassPhoto& photo : pass.photos) WritePhoto(photo, writer);
}

RecordedPass ReadPass(const std::string& file) {
  Reader reader(file);
  const auto text = [&] {
    const std::vector<uchar> bytes = reader.Bytes();
    return std::string(bytes.begin(), bytes.end());
  };
  RecordedPass pass;
  pass.name = text();
  pass.strip_file = text();
  pass.plan.seed = reader.Value<uint64_t>();
  pass.plan.event = reader.Value<WatchEvent>();
  pass.plan.change = reader.Value<SceneChange>();
  pass.plan.height_m = reader.Value<double>();
  pass.plan.tilt_deg = reader.Value<double>();
  pass.plan.noise_scale = reader.Value<double>();
  pass.photos.resize(reader.Value<size_t>());
  for (PassPhoto& photo : pass.photos) photo = ReadPhoto(reader);
  return pass;
}

std::vector<std::string> PassFilesIn(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".pass") files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace freelsd
