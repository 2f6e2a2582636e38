#include "capture/episode_writing.hpp"

#include "capture/stored_episode.hpp"

namespace ferrule {
namespace {

struct Written {
  std::size_t done, all;  // rows
};

// Writes rows to `path`; `name` is for messages. The last that it sends is that all are on the
// disk.
void write_rows(const std::string& path, const std::string& name, const EpisodeRows& rows,
                Child::Parent& parent) {
  EpisodeTables tables(rows, recorded_scene(rows.info(), name));
  hdf5::Content content = tables.content();
  content.attributes["/"][kInputsHash] =
      inputs_sha1(content, [&](const std::string& of, auto first, auto) -> hdf5::Matrix {
        const EpisodeRows::Part& part = rows.part_of(first);
        if (of == kCountsPath) return part.counts.cast<double>();
        return part.rows.middleCols<kPose>(kCommand.begin);
      });
  Written written{0, static_cast<std::size_t>(rows.count())};
  hdf5::write(path, name, content, [&] {
    if (written.done > 0) parent.send(&written, sizeof written);
    std::vector<hdf5::Matrix> values = tables.next();
    written.done += static_cast<std::size_t>(values.front().rows());
    return values;
  });
  parent.send(&written, sizeof written);
}

}  // namespace

EpisodeWriting::EpisodeWriting(const std::string& file, const Work& work)
    : written_(file),
      child_(file, Child::Work::writes,
             [&, path = written_.path()](Child::Parent& parent) { work(path, parent); }) {}

EpisodeWriting::EpisodeWriting(const std::string& file, const EpisodeRows& rows)
    : EpisodeWriting(file, [&](const std::string& path, Child::Parent& parent) {
        write_rows(path, file, rows, parent);
      }) {}

void EpisodeWriting::finish(const WriteProgress& progress, bool replace) {
  Written written{};
  do {
    child_.receive(&written, sizeof written);
    if (progress) progress(written.done, written.all);
  } while (written.done < written.all);
  written_.keep();
  written_.commit(replace);
}

void write_episode(const std::string& file, const EpisodeRows& rows,
                   const WriteProgress& progress) {
  EpisodeWriting(file, rows).finish(progress, false);
}

void rate_episode(const std::string& file, int stars) {
  EpisodeWriting(file, [&](const std::string& path, Child::Parent& parent) {
    const MappedFile before(file);
    const StoredEpisode stored(before);
    EpisodeInfo info = stored.info();
    info.rating = stars;
    write_rows(path, file, stored.rows(info), parent);
  }).finish({}, true);
}

}  // namespace ferrule
