#include "capture/recorder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>

namespace ferrule {
namespace {

namespace fs = std::filesystem;

constexpr const char* kJournal = "ferrule journal";
constexpr std::int64_t kJournalVersion = 1;
constexpr double kFlushEvery = 0.1;  // [s] of recording

// A row in the journal: its numbers, and the counts where there is a mapping.
Eigen::Index row_size(const EpisodeInfo& info) {
  return kRowSize + (info.mapping.empty() ? 0 : static_cast<Eigen::Index>(kRawAxes));
}

void append(int fd, const void* data, std::size_t size, const std::string& file) {
  if (const int error = write_all(fd, static_cast<const char*>(data), size))
    throw FileTrouble(file + ": cannot be written: " + std::strerror(error));
}

std::string header(const EpisodeInfo& info) {
  Json json = {{"format", kJournal},         {"format_version", kJournalVersion},
               {"row_size", row_size(info)}, {"scene", info.scene},
               {"operator", info.operator_}, {"seed", info.seed},
               {"trial", info.trial},        {"period_s", info.period},
               {"version", info.version},    {"build", info.build}};
  if (!info.mapping.empty()) json["mapping"] = info.mapping;
  if (!info.coupling.empty()) json["coupling"] = info.coupling;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

EpisodeInfo parse_header(const std::string& text, const std::string& file) {
  const Json json = parse_json(text, file);
  JsonFields f(json, file);
  if (f.text("format") != kJournal) f.refuse("format", std::string("must be ") + kJournal);
  f.integer("format_version", kJournalVersion, kJournalVersion);
  EpisodeInfo info;
  if (f.present("mapping")) info.mapping = f.text("mapping");
  if (f.present("coupling")) info.coupling = f.text("coupling");
  f.integer("row_size", row_size(info), row_size(info));
  info.scene = f.text("scene");
  info.operator_ = f.text("operator");
  info.seed = f.raw("seed").get<std::uint64_t>();
  info.trial = f.raw("trial").get<std::uint64_t>();
  info.period = f.number("period_s", rule::positive());
  info.version = f.text("version");
  info.build = f.text("build");
  return info;
}

// Half-written files that a killed recorder left beside the name of its episode.
void remove_half_written(const fs::path& episode) {
  const std::string begins = episode.filename().string() + ".";
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(episode.parent_path(), error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(begins) && name.ends_with(".tmp")) fs::remove(entry.path(), error);
  }
}

// Makes `file` of the rows that are whole in the journal's `text` after its header, which ends at
// `line`.
void recover_rows(const std::string& text, std::size_t line, const fs::path& journal,
                  const fs::path& file, Recovered& result) {
  Episode episode;
  episode.info = parse_header(text.substr(0, line), journal.string());
  episode.info.outcome = Outcome::interrupted;
  const Eigen::Index width = row_size(episode.info);
  result.rows = (text.size() - line - 1) / (static_cast<std::size_t>(width) * sizeof(double));
  if (fs::exists(file)) {
    const auto whole = static_cast<std::size_t>(read_episode(file.string()).rows.rows());
    if (whole < result.rows)
      throw BadInput(file.string() + " has fewer rows (" + std::to_string(whole) + ")");
    fs::remove(journal);
    result.rows = 0;
    result.remark = "was already whole as " + file.filename().string() + ": journal removed";
    return;
  }
  if (result.rows == 0) {
    fs::remove(journal);
    result.remark = "was killed before its first flush: removed";
    return;
  }
  const auto count = static_cast<Eigen::Index>(result.rows);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> numbers(count, width);
  std::memcpy(numbers.data(), text.data() + line + 1,
              static_cast<std::size_t>(numbers.size()) * sizeof(double));
  episode.rows = numbers.leftCols<kRowSize>();
  if (width > kRowSize) episode.counts = numbers.rightCols<kRawAxes>().cast<std::int32_t>();
  write_episode(file.string(), episode);
  result.file = file.string();
  fs::remove(journal);
}

Recovered recover_one(const fs::path& journal) {
  Recovered result;
  result.journal = journal.string();
  fs::path file = journal;
  file.replace_extension(".h5");

  const int fd = ::open(journal.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) {
    result.remark = std::string("cannot be read: ") + std::strerror(errno);
    result.damaged = true;
    return result;
  }
  const bool free = ::flock(fd, LOCK_EX | LOCK_NB) == 0;
  ::close(fd);
  if (!free) {
    result.remark = "is still being recorded: left alone";
    return result;
  }
  remove_half_written(file);
  const std::string text = read_text(journal.string());
  const auto line = text.find('\n');
  if (line == std::string::npos) {
    fs::remove(journal);
    result.remark = "was killed before its first row: removed";
    return result;
  }
  try {
    recover_rows(text, line, journal, file, result);
  } catch (const std::exception& error) {
    result.rows = 0;
    result.damaged = true;
    result.remark = std::string("was left as it is: ") + error.what();
  }
  return result;
}

}  // namespace

std::string episode_name(int number) {
  return fmt::format("episode_{:04}", number);
}

int next_episode_number(const std::string& folder) {
  int next = 1;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    int number = 0;
    if (std::sscanf(entry.path().filename().c_str(), "episode_%d.", &number) == 1)
      next = std::max(next, number + 1);
  }
  return next;
}

int claim_episode(const std::string& folder, int first) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw FileTrouble(folder + ": cannot be made: " + error.message());
  for (int number = first;; ++number) {
    const std::string stem = folder + "/" + episode_name(number);
    if (fs::exists(stem + ".h5")) continue;
    const std::string journal = stem + ".part";
    const int fd = ::open(journal.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0644);
    if (fd < 0 && errno == EEXIST) continue;
    if (fd < 0) throw FileTrouble(journal + ": cannot be made: " + std::strerror(errno));
    ::close(fd);
    // Another recorder may have finished this number since it was looked at.
    if (!fs::exists(stem + ".h5")) return number;
    ::unlink(journal.c_str());
  }
}

Recorder::Recorder(const std::string& folder, int number, const EpisodeInfo& info) {
  episode_.info = info;
  const std::string stem = folder + "/" + episode_name(number);
  journal_ = stem + ".part";
  file_ = stem + ".h5";
  fd_ = ::open(journal_.c_str(), O_CREAT | O_WRONLY | O_APPEND | O_CLOEXEC, 0644);
  if (fd_ < 0) throw FileTrouble(journal_ + ": cannot be made: " + std::strerror(errno));
  if (::flock(fd_, LOCK_EX | LOCK_NB) != 0 || ::lseek(fd_, 0, SEEK_END) != 0) {
    ::close(fd_);
    throw FileTrouble(journal_ + ": another recording is in it");
  }
  const std::string start = header(info);
  append(fd_, start.data(), start.size(), journal_);
}

Recorder::~Recorder() {
  if (fd_ >= 0) ::close(fd_);
}

void Recorder::add(const RowVector& row, const RawCounts& counts) {
  rows_.push_back(row);
  if (!episode_.info.mapping.empty()) counts_.push_back(counts);
  const auto per_flush =
      static_cast<std::size_t>(std::max(1.0, std::floor(kFlushEvery / episode_.info.period)));
  if (rows_.size() - flushed_ >= per_flush) flush();
}

void Recorder::flush() {
  const Eigen::Index width = row_size(episode_.info);
  std::vector<double> numbers;
  numbers.reserve((rows_.size() - flushed_) * static_cast<std::size_t>(width));
  for (std::size_t n = flushed_; n < rows_.size(); ++n) {
    numbers.insert(numbers.end(), rows_[n].begin(), rows_[n].end());
    if (width > kRowSize) numbers.insert(numbers.end(), counts_[n].begin(), counts_[n].end());
  }
  append(fd_, numbers.data(), numbers.size() * sizeof(double), journal_);
  flushed_ = rows_.size();
}

std::string Recorder::finish(Outcome outcome) {
  flush();
  episode_.info.outcome = outcome;
  episode_.rows.resize(static_cast<Eigen::Index>(rows_.size()), Eigen::NoChange);
  std::memcpy(episode_.rows.data(), rows_.data(), rows_.size() * sizeof(RowVector));
  episode_.counts.resize(static_cast<Eigen::Index>(counts_.size()), Eigen::NoChange);
  if (!counts_.empty())
    std::memcpy(episode_.counts.data(), counts_.data(), counts_.size() * sizeof(RawCounts));
  write_episode(file_, episode_);
  discard();
  return file_;
}

void Recorder::discard() noexcept {
  ::close(std::exchange(fd_, -1));
  ::unlink(journal_.c_str());
}

std::vector<Recovered> recover(const std::string& folder) {
  std::vector<Recovered> results;
  std::vector<fs::path> journals;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".part" && entry.is_regular_file())
      journals.push_back(entry.path());
  if (error) throw FileTrouble(folder + ": cannot be read: " + error.message());
  std::sort(journals.begin(), journals.end());
  for (const auto& journal : journals) results.push_back(recover_one(journal));
  return results;
}

}  // namespace ferrule
