#include "sim/base/content_hash.hpp"

#include <boost/uuid/detail/sha1.hpp>
#include <cstdio>

namespace ferrule {

std::string sha1(const std::string& bytes) {
  boost::uuids::detail::sha1 hash;
  hash.process_bytes(bytes.data(), bytes.size());
  unsigned int words[5];
  hash.get_digest(words);
  char text[41];
  std::snprintf(text, sizeof text, "%08x%08x%08x%08x%08x", words[0], words[1], words[2], words[3],
                words[4]);
  return text;
}

}  // namespace ferrule
