#include "capture/recorder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>

#include "capture/natural_order.hpp"
#include "sim/base/file_system.hpp"
#include "sim/base/written_file.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;

constexpr const char* kJournal = "ferrule journal";
constexpr std::int64_t kJournalVersion = 2;  // 1: of episodes of format 5
constexpr double kFlushEvery = 0.1;          // [s] of recording

// A row in the journal: its numbers, and the counts where there is a mapping.
Eigen::Index row_size(const EpisodeInfo& info) {
  return kRowSize + (info.mapping.empty() ? 0 : static_cast<Eigen::Index>(kRawAxes));
}

std::string header(const EpisodeInfo& info) {
  Json json = {{"format", kJournal},         {"format_version", kJournalVersion},
               {"row_size", row_size(info)}, {"scene", info.scene},
               {"operator", info.operator_}, {"seed", info.seed},
               {"trial", info.trial},        {"period_s", info.period},
               {"version", info.version},    {"build", info.build}};
  if (!info.mapping.empty()) json["mapping"] = info.mapping;
  if (!info.coupling.empty()) json["coupling"] = info.coupling;
  if (!info.trainee.empty()) json["trainee"] = info.trainee;
  if (!info.date.empty()) json["date"] = info.date;
  if (!info.session.empty()) json["session"] = info.session;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

EpisodeInfo parse_header(const std::string& text, const std::string& file) {
  const Json json = parse_json(text, file);
  JsonFields f(json, file);
  if (f.text("format") != kJournal) f.refuse("format", std::string("must be ") + kJournal);
  EpisodeInfo info;
  if (f.integer("format_version", 1, kJournalVersion) == 1) info.format = 5;
  if (f.present("mapping")) info.mapping = f.text("mapping");
  if (f.present("coupling")) info.coupling = f.text("coupling");
  if (f.present("trainee")) info.trainee = f.text("trainee");
  if (f.present("date")) info.date = f.text("date");
  if (f.present("session")) info.session = f.text("session");
  f.integer("row_size", row_size(info), row_size(info));
  info.scene = f.text("scene");
  info.operator_ = f.text("operator");
  info.seed = static_cast<std::uint64_t>(f.integer("seed", 0, INT64_MAX));
  info.trial = static_cast<std::uint64_t>(f.integer("trial", 0, INT64_MAX));
  info.period = f.number("period_s", period_rule());
  info.version = f.text("version");
  info.build = f.text("build");
  return info;
}

// Opens a journal, and locks it where the file system has locks; -1 with errno, EWOULDBLOCK where
// somebody has it. Whoever had it before may have removed the file that was opened: that is
// nobody's. Throws FileTrouble where it cannot be locked.
int open_journal(const std::string& journal, int flags) {
  const int fd = ::open(journal.c_str(), flags | O_CLOEXEC, 0644);
  if (fd < 0) return -1;
  struct stat ours {};
  struct stat there {};
  try {
    const FileLock lock = lock_file(fd, journal);
    if (lock == FileLock::none) return fd;
    if (lock == FileLock::ours && ::fstat(fd, &ours) == 0 && ::stat(journal.c_str(), &there) == 0 &&
        ours.st_ino == there.st_ino && ours.st_dev == there.st_dev)
      return fd;
  } catch (const FileTrouble&) {
    if (flags & O_CREAT) ::unlink(journal.c_str());
    ::close(fd);
    throw;
  }
  ::close(fd);
  errno = EWOULDBLOCK;
  return -1;
}

// Without locks: may somebody still be recording into a journal? A recorder writes every 100 ms.
bool may_be_recorded(const std::string& journal) {
  constexpr std::time_t kQuiet = 600;  // [s], on the clocks of all machines
  struct stat there {};
  return ::stat(journal.c_str(), &there) == 0 &&
         (there.st_size == 0 || std::time(nullptr) < there.st_mtime + kQuiet);
}

// What a journal begins with, and how many rows follow it.
struct JournalStart {
  EpisodeInfo info;
  std::size_t size;  // of its first line [bytes]; 0: it has no end
  Eigen::Index rows;
};

JournalStart read_start(const std::string& journal) {
  std::ifstream in = open_file(journal);
  std::string line;
  std::getline(in, line);
  if (in.eof()) return {{}, 0, 0};
  JournalStart start{parse_header(line, journal), line.size() + 1, 0};
  const auto bytes = static_cast<Eigen::Index>(fs::file_size(journal) - start.size);
  start.rows = bytes / (row_size(start.info) * static_cast<Eigen::Index>(sizeof(double)));
  return start;
}

using Numbers = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Rows [first, first + count) of a journal that follow its first line of `start` bytes.
Numbers read_numbers(const std::string& journal, std::size_t start, Eigen::Index width,
                     Eigen::Index first, Eigen::Index count) {
  Numbers numbers(count, width);
  std::ifstream in = open_file(journal);
  in.seekg(static_cast<std::streamoff>(start) +
           first * width * static_cast<std::streamoff>(sizeof(double)));
  in.read(reinterpret_cast<char*>(numbers.data()),
          numbers.size() * static_cast<std::streamsize>(sizeof(double)));
  if (!in) throw FileTrouble(journal + ": cannot be read");
  return numbers;
}

// Of a journal of `claim`, under whatever name it has by then.
EpisodeRows journal_rows(const EpisodeClaim& claim, const EpisodeInfo& info, std::size_t start,
                         Eigen::Index rows) {
  return {info, rows, [&claim, start, width = row_size(info)](auto first, auto count) {
            const Numbers numbers = read_numbers(claim.journal(), start, width, first, count);
            EpisodeRows::Part part;
            part.rows = numbers.leftCols<kRowSize>();
            if (width > kRowSize)
              part.counts = numbers.rightCols<kRawAxes>().template cast<std::int32_t>();
            return part;
          }};
}

// How many rows from the start on can be rows of the episode.
Eigen::Index sound_rows(const std::string& journal, const JournalStart& start) {
  for (Eigen::Index first = 0; first < start.rows; first += EpisodeRows::kBlock) {
    const Numbers numbers = read_numbers(journal, start.size, row_size(start.info), first,
                                         std::min(EpisodeRows::kBlock, start.rows - first));
    for (Eigen::Index n = 0; n < numbers.rows(); ++n) {
      const auto row = numbers.row(n);
      const auto counts = row.tail(row.size() - kRowSize).array();
      if (!row.allFinite() ||
          row[kTime.begin] != static_cast<double>(first + n) * start.info.period ||
          !(counts == counts.rint() && counts.abs() <= INT32_MAX).all())
        return first + n;
    }
  }
  return start.rows;
}

// Whether `whole` has all that a journal has.
bool agrees(const EpisodeRows& whole, const EpisodeRows& journal) {
  if (header(whole.info()) != header(journal.info()) || whole.count() < journal.count())
    return false;
  for (Eigen::Index first = 0; first < journal.count(); first += EpisodeRows::kBlock) {
    const EpisodeRows::Part &there = whole.part_of(first), &here = journal.part_of(first);
    if (there.rows.topRows(here.rows.rows()) != here.rows ||
        there.counts.topRows(here.counts.rows()) != here.counts)
      return false;
  }
  return true;
}

// How the insertion ended, where its rows say so.
Outcome outcome_of(const EpisodeRows& rows, const std::string& file) {
  const Scene scene = recorded_scene(rows.info(), file);
  InsertionWatch watch(scene, step_of(rows.row(0)).result.state);
  for (Eigen::Index n = 0; n < rows.count(); ++n)
    if (const auto seen = watch.after(step_of(rows.row(n)).result, nullptr)) return *seen;
  return Outcome::interrupted;
}

void recover_claimed(EpisodeClaim& claim, Recovered& result) {
  const auto size = fs::file_size(claim.journal());
  if (size == 0) {
    claim.remove();
    result.remark = "is empty: removed";
    return;
  }
  JournalStart start = read_start(claim.journal());
  if (start.size == 0) throw FileTrouble("its first line has no end");
  const Eigen::Index sound = sound_rows(claim.journal(), start);
  const auto rows = [&] { return journal_rows(claim, start.info, start.size, sound); };
  if (sound < start.rows) {
    const std::string kept = claim.journal() + ".damaged";
    fs::copy_file(claim.journal(), kept, fs::copy_options::overwrite_existing);
    result.damaged = true;
    result.remark = fmt::format("row {} is damaged; the journal is kept as {}", sound, kept);
  } else if (fs::exists(claim.file()) && fs::file_size(claim.file()) == 0) {
    fs::remove(claim.file());  // rename_unless_there was killed
  } else if (fs::exists(claim.file()) && agrees(open_episode(claim.file()), rows())) {
    claim.remove();
    result.remark = "was already whole as " + file_name(claim.file()) + ": journal removed";
    return;
  }
  if (sound == 0) {
    if (!result.damaged && start.size < size)
      throw FileTrouble(
          fmt::format("it ends within its first row, after {} bytes", size - start.size));
    claim.remove();
    if (!result.damaged) result.remark = "holds no rows: removed";
    return;
  }
  result.outcome = start.info.outcome = outcome_of(rows(), claim.journal());
  claim.begin(rows());
  claim.finish(rows());
  result.rows = static_cast<std::size_t>(sound);
  result.file = claim.file();
}

Recovered recover_one(const std::string& journal) {
  Recovered result;
  result.journal = journal;
  try {
    std::optional<EpisodeClaim> claim = EpisodeClaim::of_left(journal);
    if (!claim) {
      const bool held = errno == EWOULDBLOCK || errno == ENOENT;
      result.remark = held ? "is still being recorded: left alone"
                           : std::string("cannot be read: ") + std::strerror(errno);
      result.damaged = !held;
      return result;
    }
    if (!claim->locked() && may_be_recorded(journal)) {
      claim->leave();
      result.remark =
          "may still be recorded, as the file system has no locks: left alone until ten minutes "
          "after its last row";
      return result;
    }
    recover_claimed(*claim, result);
  } catch (const std::exception& error) {
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
  constexpr std::string_view kHead = "episode_";  // in capitals where a stick has it so
  int next = 1;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    std::string head = name.substr(0, kHead.size());
    for (char& c : head) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    int number = 0;
    if (head != kHead) continue;
    const char* const end = name.data() + name.size();
    const auto [rest, trouble] = std::from_chars(name.data() + kHead.size(), end, number);
    if (rest == end || *rest != '.' || rest == name.data() + kHead.size()) continue;
    if (trouble != std::errc() || number > kMostNumber)
      throw BadInput(
          fmt::format("{}: {}: numbers of episodes go up to {}", folder, name, kMostNumber));
    next = std::max(next, number + 1);
  }
  return next;
}

EpisodeClaim::EpisodeClaim(const std::string& folder, int first) : folder_(folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw FileTrouble(folder + ": cannot be made: " + error.message());
  constexpr int kMostTaken = 100;  // journals that others took as soon as they were there
  int taken = 0;
  for (number_ = first; number_ <= kMostNumber; ++number_) {
    stem_ = folder + "/" + episode_name(number_);
    if (fs::exists(file(), error)) continue;
    fd_ = open_journal(journal(), O_CREAT | O_EXCL | O_WRONLY | O_APPEND);
    if (fd_ < 0 && (errno == EEXIST || (errno == EWOULDBLOCK && ++taken < kMostTaken))) continue;
    if (fd_ < 0) throw FileTrouble(journal() + ": cannot be made: " + std::strerror(errno));
    // Another recorder may have finished this number since it was looked at.
    if (!fs::exists(file(), error)) return;
    remove();
  }
  throw FileTrouble(fmt::format("{}: no number up to {} is free", folder, kMostNumber));
}

EpisodeClaim::EpisodeClaim(EpisodeClaim&& other) noexcept
    : folder_(std::move(other.folder_)),
      stem_(std::move(other.stem_)),
      number_(other.number_),
      fd_(std::exchange(other.fd_, -1)),
      writing_(std::move(other.writing_)) {}

EpisodeClaim::~EpisodeClaim() {
  if (fd_ < 0) return;
  if (::lseek(fd_, 0, SEEK_END) == 0)
    remove();
  else
    ::close(fd_);
}

std::optional<EpisodeClaim> EpisodeClaim::of_left(const std::string& journal) {
  EpisodeClaim claim;
  claim.fd_ = open_journal(journal, O_RDWR | O_APPEND);
  if (claim.fd_ < 0) return std::nullopt;
  claim.folder_ = fs::path(journal).parent_path().string();
  claim.stem_ = fs::path(journal).replace_extension().string();
  return claim;
}

bool EpisodeClaim::locked() const {
  return lock_file(fd_, journal()) == FileLock::ours;  // which changes nothing where it is
}

void EpisodeClaim::append(const void* data, std::size_t size) const {
  if (const int error = write_all(fd_, static_cast<const char*>(data), size))
    throw FileTrouble(journal() + ": cannot be written: " + std::strerror(error));
}

void EpisodeClaim::begin(const EpisodeRows& rows) {
  std::error_code error;
  while (fs::exists(file(), error)) move_on();
  writing_ = std::make_unique<EpisodeWriting>(file(), rows);
}

void EpisodeClaim::finish(const EpisodeRows& rows, const WriteProgress& progress) {
  std::error_code error;
  for (;; begin(rows)) {
    try {
      writing_->finish(progress, false);
      return remove();
    } catch (const FileTrouble&) {
      if (!fs::exists(file(), error)) throw;  // else somebody has just taken the name
    }
  }
}

void EpisodeClaim::move_on() {
  EpisodeClaim next(folder_, number_ + 1);
  if (::rename(journal().c_str(), next.journal().c_str()) != 0)
    throw FileTrouble(journal() + ": cannot be renamed: " + std::strerror(errno));
  ::close(std::exchange(next.fd_, -1));
  stem_ = next.stem_;
  number_ = next.number_;
}

void EpisodeClaim::leave() noexcept {
  ::close(std::exchange(fd_, -1));
}

void EpisodeClaim::remove() noexcept {
  ::unlink(journal().c_str());
  ::close(std::exchange(fd_, -1));
}

Recorder::Recorder(EpisodeClaim claim, const EpisodeInfo& info)
    : claim_(std::move(claim)), info_(info) {
  const std::string start = header(info);
  start_ = start.size();
  claim_.append(start.data(), start.size());
}

void Recorder::add(const RowVector& row, const RawCounts& counts) {
  ++rows_;
  unwritten_.insert(unwritten_.end(), row.begin(), row.end());
  if (!info_.mapping.empty()) unwritten_.insert(unwritten_.end(), counts.begin(), counts.end());
  const auto per_flush =
      static_cast<std::size_t>(std::max(1.0, std::floor(kFlushEvery / info_.period)));
  if (unwritten_.size() >= per_flush * static_cast<std::size_t>(row_size(info_))) flush();
}

void Recorder::flush() {
  claim_.append(unwritten_.data(), unwritten_.size() * sizeof(double));
  unwritten_.clear();
}

EpisodeRows Recorder::journal() const {
  return journal_rows(claim_, info_, start_, static_cast<Eigen::Index>(rows_));
}

void Recorder::end(Outcome outcome) {
  flush();
  info_.outcome = outcome;
  claim_.begin(journal());
}

std::string Recorder::written(const WriteProgress& progress) {
  claim_.finish(journal(), progress);
  return claim_.file();
}

std::string Recorder::finish(Outcome outcome, const WriteProgress& progress) {
  end(outcome);
  return written(progress);
}

void Recorder::discard() noexcept {
  claim_.remove();
}

InsertionEnd record_insertion(const TrialSetup& trial, Device& device, Recorder& recorder,
                              const std::function<bool()>& go_on) {
  EpisodeInfo& info = recorder.info();
  InsertionEnd end = run_insertion(trial, device, {.period = info.period, .past_success = true},
                                   [&](const Tick& tick) {
                                     recorder.add(make_row(tick), tick.sample.counts);
                                     return !go_on || go_on();
                                   });
  info.why = end.why;
  return end;
}

std::vector<Recovered> recover(const std::string& folder,
                               const std::function<bool(std::size_t, std::size_t)>& go_on) {
  std::vector<Recovered> results;
  std::vector<std::string> journals;
  std::error_code error, ignored;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".part" && entry.is_regular_file(ignored) &&
        !entry.path().filename().string().starts_with('.'))  // as macOS leaves them beside
      journals.push_back(entry.path().string());
  if (error) throw FileTrouble(folder + ": cannot be read: " + error.message());
  std::sort(journals.begin(), journals.end(), natural_less);
  remove_half_written(folder, [](const std::string& name) { return name.ends_with(".h5"); });
  for (const auto& journal : journals) {
    if (go_on && !go_on(results.size(), journals.size())) break;
    results.push_back(recover_one(journal));
  }
  return results;
}

}  // namespace ferrule
