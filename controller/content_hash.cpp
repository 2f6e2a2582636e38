#include "controller/content_hash.hpp"

#include <fmt/format.h>

#include <boost/uuid/detail/sha1.hpp>

namespace ferrule {

std::string sha1(const std::string& bytes) {
  boost::uuids::detail::sha1 hash;
  hash.process_bytes(bytes.data(), bytes.size());
  unsigned int words[5];
  hash.get_digest(words);
  std::string text;
  for (const unsigned int word : words) text += fmt::format("{:08x}", word);
  return text;
}

}  // namespace ferrule
