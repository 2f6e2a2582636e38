#include "controller/block_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <boost/crc.hpp>
#include <boost/endian/conversion.hpp>
#include <cerrno>
#include <cstring>

#include "sim/base/error.hpp"
#include "sim/base/file_system.hpp"

namespace ferrule {
namespace {

constexpr std::string_view kMagic = "FRB1";
constexpr std::size_t kHead = 12;
constexpr std::size_t kPart = 1U << 20;       // bytes read at once, where blocks are no larger
constexpr std::uint32_t kLargest = 1U << 26;  // of a content; more is damage
// Bytes of blocks with a wrong checksum in one file; more is not damage, but made so.
constexpr std::uint64_t kMostInVain = 1U << 30;

std::uint32_t checksum(std::string_view content) {
  boost::crc_32_type crc;
  crc.process_bytes(content.data(), content.size());
  return crc.checksum();
}

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  return boost::endian::load_little_u32(reinterpret_cast<const unsigned char*>(&bytes[at]));
}

void add_number(std::string& bytes, std::uint32_t number) {
  unsigned char four[4];
  boost::endian::store_little_u32(four, number);
  bytes.append(reinterpret_cast<const char*>(four), 4);
}

// The content of the block at the start of `bytes`; empty: there is no whole one, and how many
// bytes were looked at in vain is added.
std::string_view content_at_start(std::string_view bytes, std::uint64_t& in_vain) {
  if (bytes.size() < kHead || !bytes.starts_with(kMagic)) return {};
  const std::uint32_t size = number_at(bytes, 4);
  if (size > kLargest || size > bytes.size() - kHead) return {};
  const std::string_view content = bytes.substr(kHead, size);
  if (checksum(content) == number_at(bytes, 8)) return content;
  in_vain += size;
  return {};
}

}  // namespace

std::ifstream BlockReader::open() const {
  struct stat there {};
  if (::stat(file_.c_str(), &there) == 0 && !S_ISREG(there.st_mode))
    throw FileTrouble(file_ + ": is not a regular file");
  std::ifstream in(file_, std::ios::binary);
  if (!in && ::access(file_.c_str(), F_OK) == 0)
    throw FileTrouble(file_ + ": " + std::strerror(errno));
  return in;
}

void BlockReader::read(const std::function<void(const Json&, const Place&)>& show) {
  std::ifstream in = open();
  if (!in) return;
  in_vain_ = 0;
  std::string part;
  for (std::size_t size = kPart;;) {
    part.resize(size);
    in.seekg(static_cast<std::streamoff>(end_));
    in.read(part.data(), static_cast<std::streamsize>(size));
    part.resize(static_cast<std::size_t>(in.gcount()));
    const std::uint64_t before = end_;
    show_blocks(part, show);
    cut_off_ = before + part.size() - end_;
    if (part.size() < size) return;
    if (end_ == before) size *= 2;  // a larger block, or a damaged stretch
  }
}

void BlockReader::show_blocks(std::string_view part,
                              const std::function<void(const Json&, const Place&)>& show) {
  for (std::size_t passed = 0; passed < part.size();) {
    const std::string_view content = content_at_start(part.substr(passed), in_vain_);
    if (in_vain_ > kMostInVain)
      throw FileTrouble(file_ + ": is damaged: it begins blocks that do not end");
    const Json block =
        content.empty() ? Json(Json::value_t::discarded) : Json::from_cbor(content, true, false);
    if (block.is_discarded()) {
      passed = part.find(kMagic, passed + 1);
      continue;
    }
    show(block, {end_ + passed + kHead, content.size()});
    damaged_ += passed > 0;
    const std::size_t whole = passed + kHead + content.size();
    part.remove_prefix(whole);
    end_ += whole;
    passed = 0;
  }
}

Json BlockReader::read_again(const Place& place) const {
  std::ifstream in = open();
  std::string content(place.size, '\0');
  in.seekg(static_cast<std::streamoff>(place.at));
  if (!in.read(content.data(), static_cast<std::streamsize>(content.size())))
    throw FileTrouble(file_ + ": has become shorter");
  return Json::from_cbor(content);
}

BlockWriter::BlockWriter(const std::string& file)
    : file_(file),
      fd_(::open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK,
                 0666)) {
  if (fd_ < 0)
    throw FileTrouble(file + ": " + (errno == ELOOP ? "is a link" : std::strerror(errno)));
  try {
    const FileLock lock = lock_file(fd_, file);
    if (lock == FileLock::others)
      throw FileTrouble(file + ": another process is writing to it: give each its own shard");
    locked_ = lock == FileLock::ours;
    cut_off_rest();
  } catch (...) {
    ::close(fd_);
    throw;
  }
}

void BlockWriter::cut_off_rest() const {
  BlockReader reader(file_);
  reader.read([](const Json&, const BlockReader::Place&) {});
  if (reader.cut_off() == 0) return;
  char start[kMagic.size()];
  const ssize_t n = ::pread(fd_, start, sizeof start, 0);
  const std::string_view begins(start, static_cast<std::size_t>(std::max<ssize_t>(0, n)));
  // Zeros are what is left of a file that had not come to the disk.
  if (reader.end() == 0 && !kMagic.starts_with(begins) && !begins.starts_with('\0'))
    throw FileTrouble(file_ + ": is no file of a shard, or damaged at its start: remove it");
  if (::ftruncate(fd_, static_cast<off_t>(reader.end())) != 0)
    throw FileTrouble(file_ + ": " + std::strerror(errno));
}

BlockWriter::~BlockWriter() {
  ::close(fd_);
}

void BlockWriter::append(const Json& block) {
  std::string content;
  Json::to_cbor(block, content);
  std::string bytes(kMagic);
  add_number(bytes, static_cast<std::uint32_t>(content.size()));
  add_number(bytes, checksum(content));
  bytes += content;
  const off_t before = ::lseek(fd_, 0, SEEK_END);
  int error = write_all(fd_, bytes.data(), bytes.size());
  if (error == 0) error = sync_file(fd_, ::fdatasync);
  if (error == 0) return;
  if (before < 0 || ::ftruncate(fd_, before) != 0) error = errno;
  throw FileTrouble(file_ + ": " + std::strerror(error));
}

}  // namespace ferrule
