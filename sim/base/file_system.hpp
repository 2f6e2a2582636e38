// What some file systems lack (Lustre and NFS without locks, exFAT and SMB without links), and what
// is done without it. An error of any other kind is one.
#pragma once

#include <unistd.h>

#include <string>

namespace ferrule {

// Of an open file, by flock: it lasts until the file is closed, or the process ends.
enum class FileLock {
  ours,
  others,  // somebody else has it
  none     // the file system has no locks
};
// `wait` until somebody else gives it back. Throws FileTrouble, naming `file`.
FileLock lock_file(int fd, const std::string& file, bool wait = false);

// Brings what was written to the disk, where the file system can. Returns 0 or errno.
int sync_file(int fd, int (*sync)(int) = ::fsync) noexcept;

// Gives a file another name unless something has that. Without links and renames that do not
// replace, an empty file has the name for a moment. Returns 0 or errno.
int rename_unless_there(const std::string& from, const std::string& to) noexcept;

}  // namespace ferrule
