#include "sim/base/content_hash.hpp"

#include <array>
#include <boost/uuid/detail/sha1.hpp>
#include <cstdio>
#include <fstream>

#include "sim/base/json_fields.hpp"

namespace ferrule {

struct Sha1::State {
  boost::uuids::detail::sha1 hash;
};

Sha1::Sha1() : state_(std::make_unique<State>()) {}
Sha1::~Sha1() = default;

void Sha1::add(const void* bytes, std::size_t size) {
  state_->hash.process_bytes(bytes, size);
}

std::string Sha1::text() {
  unsigned int words[5];
  state_->hash.get_digest(words);
  char text[41];
  std::snprintf(text, sizeof text, "%08x%08x%08x%08x%08x", words[0], words[1], words[2], words[3],
                words[4]);
  return text;
}

std::string sha1(const std::string& bytes) {
  Sha1 hash;
  hash.add(bytes.data(), bytes.size());
  return hash.text();
}

std::string sha1_of_file(const std::string& file) {
  std::ifstream in = open_file(file);
  Sha1 hash;
  std::array<char, 1 << 16> piece;
  while (in.read(piece.data(), piece.size()) || in.gcount() > 0)
    hash.add(piece.data(), static_cast<std::size_t>(in.gcount()));
  if (in.bad()) throw FileTrouble(file + ": cannot be read");
  return hash.text();
}

}  // namespace ferrule
