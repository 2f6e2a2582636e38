// A file that is written beside its name and gets it when it is whole.
#pragma once

#include <functional>
#include <string>

namespace ferrule {

class WrittenFile {
 public:
  // Writes `text` beside `name`; a link is followed. Also removes what killed runs left there
  // half-written. Throws FileTrouble.
  WrittenFile(const std::string& name, std::string text);
  // An empty one, which others fill at path(). Throws FileTrouble.
  explicit WrittenFile(const std::string& name);
  WrittenFile(const WrittenFile&) = delete;
  WrittenFile& operator=(const WrittenFile&) = delete;
  // Removes what has not got its name.
  ~WrittenFile();

  // Beside its name. Throws FileTrouble where it is a device or a pipe.
  const std::string& path() const;
  // Brings what was written at path() to the disk. Throws FileTrouble.
  void keep();

  // Gives it its name; to a device or a pipe of that name it is written now. With `replace` false
  // an existing file is left alone. Throws FileTrouble.
  void commit(bool replace = true);

 private:
  std::string name_, text_, file_, beside_;
  int fd_ = -1;  // locked while it is being written
};

// Removes the half-written files of killed runs in `folder` that were to become a file of a name
// that is `wanted`; those that are being written are left alone, and where the file system has no
// locks all of them.
void remove_half_written(const std::string& folder,
                         const std::function<bool(const std::string& name)>& wanted);

}  // namespace ferrule
