// The raw still of a camera (DNG, CR2, NEF and what else LibRaw knows): the codes of its sensor as a Bayer
// mosaic, linear, with the black level and the exposure that the file states. Codes at the sensor's white
// level become the largest code, so that clipped is clipped. The camera's white balance is a fact beside the
// mosaic, which stays what the sensor saw.
#pragma once

#include <memory>
#include <string>

#include "hal/footage/picture_file.h"
#include "hal/storage.h"

namespace hdrcam {

// Whether the name is that of a raw still: .dng, .cr2, .nef and their like.
bool is_raw_still(const std::string& path);

// Errors: NotFound, Permission; NotRecording for what LibRaw does not know; Corrupt; Unsupported for a sensor
// without a Bayer mosaic, and for tiles that LibRaw would mix up.
Result<std::unique_ptr<PictureFile>> open_raw_still(Storage& storage, const std::string& path);

}  // namespace hdrcam
