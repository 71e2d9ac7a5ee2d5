#include "online/response/blur_between.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "capture/clip_policy.h"

namespace hdrcam {
namespace {

constexpr float kWhite = 255;

// Light, 0..1 of white, by the curve of a usual camera: the response is not known yet.
constexpr float kUsualPower = 2.2f;
float light_of(float code) { return std::pow(std::clamp(code * (1 / kWhite), 0.f, 1.f), kUsualPower); }

// Codes by the square root of light, which resolves the darkest.
float code_of(float light) {
  static constexpr std::size_t kRoots = 4096;
  static const std::array<float, kRoots> codes = [] {
    std::array<float, kRoots> table{};
    for (std::size_t i = 0; i < kRoots; ++i)
      table[i] = kWhite * std::pow(static_cast<float>(i) / (kRoots - 1), 2 / kUsualPower);
    return table;
  }();
  return codes[static_cast<std::size_t>(std::sqrt(light) * (kRoots - 1) + 0.5f)];
}

// The mean of so many pixels around each, along rows. Beyond an edge all is as at the edge.
void average_rows(Image<float>& light, float length) {
  const int cols = light.cols(), margin = static_cast<int>(std::ceil(length / 2)) + 1;
  const float begin = 0.5f - length / 2 + static_cast<float>(margin), end = begin + length;
  const auto first = static_cast<std::size_t>(begin), last = static_cast<std::size_t>(end);
  const double before = begin - static_cast<float>(first), after = end - static_cast<float>(last);
  std::vector<float> padded(static_cast<std::size_t>(cols + 2 * margin));
  std::vector<double> sums(padded.size() + 1);  // of the pixels before each
  for (int y = 0; y < light.rows(); ++y) {
    float* row = light.row(0, y);
    std::fill_n(padded.begin(), margin, row[0]);
    std::copy_n(row, cols, padded.begin() + margin);
    std::fill_n(padded.end() - margin, margin, row[cols - 1]);
    for (std::size_t i = 0; i < padded.size(); ++i) sums[i + 1] = sums[i] + static_cast<double>(padded[i]);
    for (int x = 0; x < cols; ++x) {
      const std::size_t from = first + static_cast<std::size_t>(x), to = last + static_cast<std::size_t>(x);
      const double sum = sums[to] + after * static_cast<double>(padded[to]) - sums[from] -
                         before * static_cast<double>(padded[from]);
      row[x] = std::clamp(static_cast<float>(sum / static_cast<double>(length)), 0.f, 1.f);
    }
  }
}

void transpose(Image<float>& picture) {
  Image<float> turned;
  turned.reshape(1, picture.cols(), picture.rows());
  for (int y = 0; y < picture.rows(); ++y)
    for (int x = 0; x < picture.cols(); ++x) turned.at(0, x, y) = picture.at(0, y, x);
  std::swap(picture, turned);
}

void average(Image<float>& light, const BlurLengths& lengths) {
  if (lengths.x > 1) average_rows(light, lengths.x);
  if (lengths.y > 1) transpose(light), average_rows(light, lengths.y), transpose(light);
}

// Means over squares of pixels and over the channels.
Image<float> reduced(const Image<float>& codes, int side) {
  Image<float> means(1, codes.rows() / side, codes.cols() / side);
  const float scale = 1 / static_cast<float>(codes.channels() * side * side);
  for (int y = 0; y < means.rows(); ++y)
    for (int c = 0; c < codes.channels(); ++c)
      for (int line = 0; line < side; ++line) {
        const float* row = codes.row(c, y * side + line);
        for (int x = 0; x < means.cols(); ++x)
          for (int i = 0; i < side; ++i) means.at(0, y, x) += scale * row[x * side + i];
      }
  return means;
}

// How many pixels are darker than each of a thousand codes.
class Ranks {
 public:
  explicit Ranks(const Image<float>& codes) {
    for (const float code : codes.samples()) ++darker_[place_of(code) + 1];
    for (std::size_t i = 1; i <= kBins; ++i) darker_[i] += darker_[i - 1];
  }

  using Table = std::array<float, 1024>;
  // By the code of these, the code of the others that as many pixels are darker than.
  Table brought_to(const Ranks& others) const {
    Table codes{};
    std::size_t at = 0;
    for (std::size_t i = 0; i < kBins; ++i) {
      const double wanted = 0.5 * (darker_[i] + darker_[i + 1]);
      while (at < kBins - 1 && others.darker_[at + 1] < wanted) ++at;
      const double here = others.darker_[at + 1] - others.darker_[at];
      const double part = here > 0 ? std::clamp((wanted - others.darker_[at]) / here, 0.0, 1.0) : 0.5;
      codes[i] = static_cast<float>((static_cast<double>(at) + part) / kPerCode);
    }
    return codes;
  }
  static float at(const Table& table, float code) { return table[place_of(code)]; }

 private:
  static constexpr std::size_t kBins = std::tuple_size_v<Table>;
  static constexpr double kPerCode = kBins / 256.0;
  static std::size_t place_of(float code) {
    return static_cast<std::size_t>(std::clamp(code, 0.f, kWhite) * static_cast<float>(kPerCode));
  }

  std::array<double, kBins + 1> darker_{};
};

// Means of products of two differences across the same distance, in lines so far apart that their noise
// differs: of neighbours, fine, and of pixels four apart, coarse; codes^2.
struct Texture {
  double fine_x = 0, fine_y = 0, coarse_x = 0, coarse_y = 0;
  double seen = 0;  // the share of the area's pixels that counted
};

struct Area {
  int x0, y0, x1, y1;
};

Area all_of(const Image<float>& picture) { return {0, 0, picture.cols(), picture.rows()}; }

Texture texture_of(const Image<float>& picture, const Area& area, float darkest) {
  constexpr int kApart = 2, kFar = 4;  // pixels
  const auto shows = [&](float code) { return code > darkest && code < clip_policy::kBlurClipped; };
  Texture sum;
  double fine = 0, coarse = 0;
  for (int y = area.y0; y + kFar < area.y1; ++y) {
    const float *a = picture.row(0, y), *below = picture.row(0, y + 1), *apart = picture.row(0, y + kApart),
                *far = picture.row(0, y + kFar);
    for (int x = area.x0; x + kFar < area.x1; ++x) {
      if (!(shows(a[x]) && shows(a[x + 1]) && shows(a[x + kApart]) && shows(below[x]) &&
            shows(below[x + kApart]) && shows(apart[x]) && shows(apart[x + 1])))
        continue;
      sum.fine_x += static_cast<double>((a[x + 1] - a[x]) * (apart[x + 1] - apart[x]));
      sum.fine_y += static_cast<double>((below[x] - a[x]) * (below[x + kApart] - a[x + kApart]));
      ++fine;
      if (!(shows(a[x + kFar]) && shows(apart[x + kFar]) && shows(far[x]) && shows(far[x + kApart])))
        continue;
      sum.coarse_x += static_cast<double>((a[x + kFar] - a[x]) * (apart[x + kFar] - apart[x]));
      sum.coarse_y += static_cast<double>((far[x] - a[x]) * (far[x + kApart] - a[x + kApart]));
      ++coarse;
    }
  }
  const double seen = fine / ((area.x1 - area.x0) * (area.y1 - area.y0));
  fine = std::max(fine, 1.0), coarse = std::max(coarse, 1.0);
  return {sum.fine_x / fine, sum.fine_y / fine, sum.coarse_x / coarse, sum.coarse_y / coarse, seen};
}

constexpr double kEnoughSeen = 0.2;  // of an area

// Whether fine texture is lost that coarse texture does not lose, along an axis.
bool loses_fine(double fine, double coarse, double fine_left, double coarse_left) {
  constexpr double kLeft = 0.92;  // of the fine texture, against the coarse: more left is no loss
  return fine_left * coarse < kLeft * fine * coarse_left;
}

// How far the fine texture of one is from that of the other.
double distance(const Texture& a, const Texture& b) {
  const auto off = [](double p, double q) {
    constexpr double kNone = 1;  // codes^2
    return std::abs(std::log(std::max(p, kNone) / std::max(q, kNone)));
  };
  return off(a.fine_x, b.fine_x) + off(a.fine_y, b.fine_y);
}

bool alike(const Texture& a, const Texture& b) {
  constexpr double kMostRatio = 1.25;
  const auto near = [](double p, double q) { return p < kMostRatio * q && q < kMostRatio * p; };
  return near(a.fine_x, b.fine_x) && near(a.fine_y, b.fine_y) && near(a.coarse_x, b.coarse_x) &&
         near(a.coarse_y, b.coarse_y);
}

// Of two pictures of one channel: the shorter one, blurred and with the codes of the longer one.
class BlurSearch {
 public:
  BlurSearch(const Image<float>& shorter, Image<float> longer)
      : light_(shorter.clone()), longer_(std::move(longer)), ranks_(longer_) {
    constexpr float kDarkest = 12;  // codes of the shorter one: noise and steps are all of what is darker
    darkest_ = Ranks::at(Ranks(shorter).brought_to(ranks_), kDarkest);
    for (float& sample : light_.samples()) sample = light_of(sample);
    wanted_ = texture_of(longer_);
  }

  BlurLengths find() const {
    constexpr int kRounds = 2;  // the texture along an axis depends on the blur across it, too
    const Image<float> sharp = blurred({});
    const Texture before = texture_of(sharp);
    if (std::min(before.seen, wanted_.seen) < kEnoughSeen) return {};
    const bool along_x = loses_fine(before.fine_x, before.coarse_x, wanted_.fine_x, wanted_.coarse_x),
               along_y = loses_fine(before.fine_y, before.coarse_y, wanted_.fine_y, wanted_.coarse_y);
    if (!along_x && !along_y) return {};
    BlurLengths found;
    for (int round = 0; round < kRounds; ++round) {
      if (along_x)
        found.x = settled(wanted_.fine_x, &Texture::fine_x, [&](float x) { return BlurLengths{x, found.y}; });
      if (along_y)
        found.y = settled(wanted_.fine_y, &Texture::fine_y, [&](float y) { return BlurLengths{found.x, y}; });
    }
    return is_blur(found, sharp) ? found : BlurLengths{};
  }

 private:
  // The length with which there is no more of a texture than is wanted.
  template <class With>
  float settled(double wanted, double Texture::*texture, With&& with) const {
    constexpr float kLongest = 16;  // pixels
    constexpr int kSteps = 6;
    float shorter = 1, longer = kLongest;
    for (int step = 0; step < kSteps; ++step) {
      const float length = std::sqrt(shorter * longer);
      (texture_of(blurred(with(length))).*texture > wanted ? shorter : longer) = length;
    }
    return shorter;
  }

  // Whether it makes the sharp picture like the longer one: also in its coarse texture, and in most of the
  // picture, which what only one of both has, or a blur of some objects alone, does not.
  bool is_blur(const BlurLengths& lengths, const Image<float>& sharp) const {
    constexpr float kLeastLength = 1.25f;  // pixels; less is what cameras' own processing does
    constexpr int kTiles = 5;              // along each side
    constexpr double kLeastNearer = 0.55;  // share of the tiles that are seen in all pictures
    if (std::max(lengths.x, lengths.y) < kLeastLength) return false;
    const Image<float> picture = blurred(lengths);
    if (!alike(texture_of(picture), wanted_)) return false;
    const int rows = sharp.rows() / kTiles, cols = sharp.cols() / kTiles;
    int seen = 0, nearer = 0;
    for (int i = 0; i < kTiles * kTiles; ++i) {
      const int x = i % kTiles * cols, y = i / kTiles * rows;
      const Area tile{x, y, x + cols, y + rows};
      const Texture before = hdrcam::texture_of(sharp, tile, darkest_),
                    after = hdrcam::texture_of(picture, tile, darkest_),
                    wanted = hdrcam::texture_of(longer_, tile, darkest_);
      if (std::min({before.seen, after.seen, wanted.seen}) < kEnoughSeen) continue;
      ++seen, nearer += distance(after, wanted) < distance(before, wanted);
    }
    return nearer >= kLeastNearer * seen;
  }

  Image<float> blurred(const BlurLengths& lengths) const {
    Image<float> picture = light_.clone();
    average(picture, lengths);
    for (float& sample : picture.samples()) sample = code_of(sample);
    const Ranks::Table codes = Ranks(picture).brought_to(ranks_);
    for (float& sample : picture.samples()) sample = Ranks::at(codes, sample);
    return picture;
  }
  Texture texture_of(const Image<float>& picture) const {
    return hdrcam::texture_of(picture, all_of(picture), darkest_);
  }

  Image<float> light_;  // of the shorter one
  const Image<float> longer_;
  const Ranks ranks_;  // of the longer one
  float darkest_ = 0;  // code of the longer one
  Texture wanted_;     // of the longer one
};

}  // namespace

BlurLengths blur_between(const Image<float>& shorter, const Image<float>& longer) {
  constexpr int kUsualCols = 320, kLeastSide = 16;
  const int side = std::max(1, shorter.cols() / kUsualCols);
  if (std::min(shorter.rows(), shorter.cols()) < kLeastSide * side) return {};
  BlurLengths lengths = BlurSearch(reduced(shorter, side), reduced(longer, side)).find();
  for (float* length : {&lengths.x, &lengths.y})
    if (*length > 1) *length *= static_cast<float>(side);
  return lengths;
}

void blur_channel(const Image<float>& codes, int channel, const BlurLengths& lengths, Image<float>& blurred) {
  blurred.reshape(1, codes.rows(), codes.cols());
  std::transform(codes.plane(channel), codes.plane(channel) + codes.plane_size(), blurred.plane(0), light_of);
  average(blurred, lengths);
  for (float& sample : blurred.samples()) sample = code_of(sample);
}

}  // namespace hdrcam
