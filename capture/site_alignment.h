// Aligns the sites of two frames' signatures: how far the picture moved between them, found from bitmaps that
// are the same for every exposure. Reentrant; no allocation.
#pragma once

#include <algorithm>

#include "capture/photometry.h"

namespace hdrcam {

// The content at site (y, x) of one frame is at (y + dy, x + dx) of another.
struct SiteShift {
  int dy = 0, dx = 0;
  double overlap = 1;  // share of the sites that both frames see
};

// The shift under which the frames' bitmaps differ least, at most 6 sites and a fifth of either side; zero
// where the frames have no common rank. Both have the same sites.
SiteShift align(const PhotometricSignature& a, const PhotometricSignature& b);

// Calls body(value in a, value in b) for the sites that both frames see.
template <class Body>
void for_shared_sites(const PhotometricSignature& a, const PhotometricSignature& b, SiteShift shift,
                      Body&& body) {
  const int y1 = std::min(a.rows, a.rows - shift.dy), x1 = std::min(a.cols, a.cols - shift.dx);
  for (int y = std::max(0, -shift.dy); y < y1; ++y)
    for (int x = std::max(0, -shift.dx); x < x1; ++x)
      body(a.at_site[a.index_of(y, x)], b.at_site[a.index_of(y + shift.dy, x + shift.dx)]);
}

// Pearson's correlation of the sites that both frames see.
double correlation(const PhotometricSignature& a, const PhotometricSignature& b, SiteShift shift);

}  // namespace hdrcam
