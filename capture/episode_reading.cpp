// Files of strangers are read in a child process with limits.
#include <algorithm>
#include <memory>

#include "capture/child.hpp"
#include "capture/stored_episode.hpp"

namespace ferrule {
namespace {

// To and from a child.
Json to_json(const EpisodeInfo& info, Eigen::Index rows) {
  return {info.scene,    info.operator_, info.seed,    info.trial,  info.period,
          info.outcome,  info.why,       info.version, info.build,  info.mapping,
          info.coupling, info.phases,    info.loop,    info.rating, info.inputs_sha1,
          info.trainee,  info.date,      info.session, info.format, rows};
}
EpisodeInfo info_of(const Json& j) {
  EpisodeInfo info{j[0],  j[1],  j[2],  j[3],  j[4],  j[5],  j[6],  j[7],  j[8], j[9],
                   j[10], j[11], j[12], j[13], j[14], j[15], j[16], j[17], j[18]};
  return info;
}

// A file of which a child sends one block of rows after the other.
class EpisodeStream {
 public:
  // `hash`, unless null, becomes that of its bytes.
  EpisodeStream(const std::string& file, std::string* hash) : file_(file) { start(0, hash); }

  const EpisodeInfo& info() const noexcept { return info_; }
  Eigen::Index count() const noexcept { return count_; }
  EpisodeRows::Part read(Eigen::Index first, Eigen::Index count) {
    if (first != next_) start(first, nullptr);
    EpisodeRows::Part part;
    part.rows.resize(count, Eigen::NoChange);
    receive_numbers(part.rows);
    if (!info_.mapping.empty()) part.counts.resize(count, Eigen::NoChange);
    receive_numbers(part.counts);
    next_ += count;
    return part;
  }

 private:
  void start(Eigen::Index first, std::string* hash);
  template <class Numbers>
  void receive_numbers(Numbers& numbers) {
    child_->receive(numbers.data(),
                    static_cast<std::size_t>(numbers.size()) * sizeof(typename Numbers::Scalar));
  }

  MappedFile file_;
  std::unique_ptr<Child> child_;
  EpisodeInfo info_;
  Eigen::Index count_ = 0, next_ = 0;
};

template <class Numbers>
void send_numbers(Child::Parent& parent, const Numbers& numbers) {
  parent.send(numbers.data(),
              static_cast<std::size_t>(numbers.size()) * sizeof(typename Numbers::Scalar));
}

void EpisodeStream::start(Eigen::Index from, std::string* hash) {
  child_ = std::make_unique<Child>(file_.name(), Child::Work::reads, [&](Child::Parent& parent) {
    const StoredEpisode stored(file_);
    parent.send_json(to_json(stored.info(), stored.count()));
    if (hash) parent.send_json(file_.sha1());
    for (Eigen::Index first = from; first < stored.count(); first += EpisodeRows::kBlock) {
      const EpisodeRows::Part part =
          stored.read(first, std::min(EpisodeRows::kBlock, stored.count() - first));
      send_numbers(parent, part.rows);
      send_numbers(parent, part.counts);
    }
  });
  const Json info = child_->receive_json();
  info_ = info_of(info);
  count_ = info.back().get<Eigen::Index>();
  if (hash) *hash = child_->receive_json().get<std::string>();
  next_ = from;
}

}  // namespace

EpisodeRows open_episode(const std::string& file, std::string* hash) {
  const auto stream = std::make_shared<EpisodeStream>(file, hash);
  return {stream->info(), stream->count(),
          [stream](Eigen::Index first, Eigen::Index count) { return stream->read(first, count); }};
}

Episode read_episode(const std::string& file) {
  const EpisodeRows stored = open_episode(file);
  Episode episode{stored.info(), {}, {}};
  episode.rows.resize(stored.count(), Eigen::NoChange);
  if (!episode.info.mapping.empty()) episode.counts.resize(stored.count(), Eigen::NoChange);
  for (Eigen::Index n = 0; n < stored.count(); n += EpisodeRows::kBlock) {
    const EpisodeRows::Part& part = stored.part_of(n);
    episode.rows.middleRows(n, part.rows.rows()) = part.rows;
    if (part.counts.rows() > 0) episode.counts.middleRows(n, part.counts.rows()) = part.counts;
  }
  return episode;
}

}  // namespace ferrule
