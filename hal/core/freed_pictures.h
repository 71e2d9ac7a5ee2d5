// What the C library does with the memory of pictures that are freed. Of the whole process; without effect
// where the C library is not glibc.
#pragma once

namespace hdrcam {

// Those above 4 MiB go back to the system, for a process that goes on for long. By default the library keeps
// them for later as soon as a large block was freed once, in a heap that no other size fits into. Smaller
// ones, as those of 640x480 are, stay, in one heap for all threads: what the first frames needed for a moment
// serves the next ones, and the system need not clear it again, which on some machines takes longer than the
// work.
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
