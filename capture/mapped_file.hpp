// A file's bytes, which the system brings into memory where they are used.
#pragma once

#include <boost/interprocess/mapped_region.hpp>
#include <cstddef>
#include <string>

namespace ferrule {

// They stay those of this file, whatever its name leads to later. Where the file is cut, using what
// it has no more ends the process: strangers' files are used in a Child (capture/child.hpp).
class MappedFile {
 public:
  // Throws FileTrouble.
  explicit MappedFile(const std::string& file);

  const std::string& name() const noexcept { return name_; }
  const char* data() const noexcept { return static_cast<const char*>(region_.get_address()); }
  std::size_t size() const noexcept { return region_.get_size(); }
  // Takes no memory until it is used again.
  void forget() const noexcept;
  // SHA-1 of the bytes, as sha1_of_file.
  std::string sha1() const;

 private:
  std::string name_;
  boost::interprocess::mapped_region region_;
};

}  // namespace ferrule
