// What the C library does with the memory of pictures that are freed. Of the whole process; without effect
// where the C library is not glibc.
#pragma once

namespace hdrcam {

// They go back to the system, for a process that goes on for long. By default the library keeps them for
// later as soon as a large block was freed once, in a heap that no other size fits into. Smaller blocks stay:
// a library that writes a frame frees and takes them dozens of times, and each time the system would clear
// them.
void give_back_freed_pictures();

// For as long as this lives those below 32 MiB stay, for work that makes and frees many of a few sizes and
// then ends. Its end sets the limits of give_back_freed_pictures().
class FreedPicturesStay {
 public:
  FreedPicturesStay();
  ~FreedPicturesStay() { give_back_freed_pictures(); }
  FreedPicturesStay(const FreedPicturesStay&) = delete;
  FreedPicturesStay& operator=(const FreedPicturesStay&) = delete;
};

}  // namespace hdrcam
