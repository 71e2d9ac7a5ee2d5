// The raw still of a camera (DNG, CR2, NEF and what else LibRaw knows): the codes of its sensor as a Bayer
// mosaic, linear, with the black level and the exposure that the file states. They are stretched so that the
// sensor's white level becomes the largest code: what is clipped is as bright as its code says. The camera's
// white balance is a fact beside the mosaic, which stays what the sensor saw. Reentrant.
#pragma once

#include <memory>
#include <string>

#include "hal/footage/picture_file.h"
#include "hal/storage.h"

namespace hdrcam {

// Whether the name is that of a raw still: .dng, .cr2, .nef and their like.
bool is_raw_still(const std::string& path);

// clip_white: the code that becomes the largest one, the same for all stills of a clip, so that their codes
// compare; 0: the white level of this one. Errors: NotFound, Permission; NotRecording for what LibRaw does
// not know; Corrupt; Unsupported for a sensor without a Bayer mosaic, and for tiles that LibRaw would mix up.
Result<std::unique_ptr<PictureFile>> open_raw_still(Storage& storage, const std::string& path,
                                                    int clip_white);

}  // namespace hdrcam
