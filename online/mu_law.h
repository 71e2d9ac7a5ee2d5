// The mu-law by which radiance is judged as an eye would: log(1 + mu x) / log(1 + mu), x in units of white
// (PSNR-mu, Kalantari and Ramamoorthi 2017). Below 1 / mu of white it is linear: differences there are hardly
// visible. Reentrant.
#pragma once

namespace hdrcam {

constexpr float kPsnrMu = 5000;

// The radiance below which a difference is hardly visible. white: the radiance that is shown as white.
constexpr float barely_visible(float white) { return white * (1 / kPsnrMu); }

}  // namespace hdrcam
