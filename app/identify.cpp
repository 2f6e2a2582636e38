// ferrule identify: physical parameters of the scene from recorded forces.
#include "learn/identify.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/progress.hpp"
#include "app/scene_arguments.hpp"
#include "app/trial_arguments.hpp"
#include "app/verbs.hpp"
#include "capture/episode_copies.hpp"
#include "learn/shuffle.hpp"
#include "sim/scene/draw.hpp"
#include "sim/scene/terms.hpp"

namespace ferrule {
namespace {

constexpr std::size_t kEpisodes = 4;
constexpr double kNoted = 0.9;  // correlation that is noted

struct IdentifyArguments {
  SceneArguments scene;
  std::string folder;
  std::vector<std::string> parameters;
  std::uint64_t seed = 1;
  Output output;
};

struct Chosen {
  std::vector<Recording> recordings;
  ChosenScene scene;
};

// Up to kEpisodes episodes of the folder, and the scene to start from.
Chosen choose(const IdentifyArguments& a, Provenance& provenance) {
  Chosen chosen;
  BroughtScene brought{{}, a.folder + " was recorded in", ""};
  const std::vector<std::string> files = episode_files(a.folder);
  EpisodeCopies copies;
  for (const std::size_t drawn : shuffled(files.size(), a.seed)) {
    if (chosen.recordings.size() == kEpisodes) break;
    const std::string& file = files[drawn];
    const Episode episode = read_episode(file);
    if (episode.rows.rows() < 2) continue;
    end_if_interrupted();
    if (const auto copy = copies.seen(episode, file)) {
      fmt::print(stderr, "note: {}\n", printable(copy->text()));
      continue;
    }
    provenance.read(file);
    const Json document = undrawn(parse_json(episode.info.scene, file));
    if (!chosen.recordings.empty() && document != brought.document)
      brought.open = file + ": was recorded in another scene than the others";
    brought.document = document;
    chosen.recordings.push_back(recording(episode, file));
  }
  if (chosen.recordings.empty()) throw BadInput(a.folder + ": too few episodes: none");
  if (!brought.open.empty()) brought.document = nullptr;
  chosen.scene = a.scene.choose(brought);
  provenance.in(chosen.scene).seed("episodes and starts", a.seed);
  return chosen;
}

// Each pair of parameters with its correlation.
template <class Do>
void for_each_pair(const Identification& found, const Do& act) {
  for (std::size_t i = 0; i < found.parameters.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      act(found.parameters[j].key, found.parameters[i].key,
          found.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
}

// What a scene may state of fibre, ferrule and forces, and this one does not.
std::vector<std::string> not_stated(const Scene& scene) {
  std::vector<std::string> keys;
  const Json document = scene.document();
  for (const char* key : {"fibre.edge_um", "fibre.cleave_deg", "fibre.curl_radius_m",
                          "ferrule.ovality_um", "ferrule.lead_in"})
    if (const auto at = pointer_to(key); !document.contains(at) || document.at(at).is_null())
      keys.emplace_back(key);
  for (const Term term : kAllTerms)
    if (info(term).read && !info(term).present(scene.parameters.laws))
      keys.push_back("laws." + std::string(info(term).name));
  return keys;
}

// Empty where the scene explains the forces.
std::string warning(const Scene& scene, const Identification& found) {
  if (found.fits()) return "";
  return fmt::format(
      "the scene does not explain the forces: what is left of them is {:.2f} times the noise of "
      "the sensor, which by itself hardly exceeds {:.2f}. The scene lacks something, or a number "
      "that is held fixed is wrong; values may be far off, and the intervals are {:.2f} times "
      "wider "
      "for it. Not stated in it: {}",
      found.misfit, found.misfit_limit, found.misfit, fmt::join(not_stated(scene), ", "));
}

Json to_json(const IdentifyArguments& a, const Chosen& chosen, const Identification& found) {
  Json parameters = Json::object(), correlations = Json::array();
  for (const IdentifiedParameter& p : found.parameters)
    parameters[p.key] = {{"told", name(p.told)},
                         {"value", number_or_null(p.value)},
                         {"low", number_or_null(p.low)},
                         {"high", number_or_null(p.high)},
                         {"start", p.start},
                         {"lowest", p.lowest},
                         {"highest", p.highest}};
  for_each_pair(found, [&](const std::string& one, const std::string& other, double r) {
    correlations.push_back({{"a", one}, {"b", other}, {"correlation", r}});
  });
  return {{"scene", chosen.scene.scene.name},
          {"episodes", json_list(chosen.recordings, [](const Recording& r) { return r.file; })},
          {"rows", found.rows},
          {"seed", a.seed},
          {"parameters", parameters},
          {"correlations", correlations},
          {"residual_start_uN", 1e6 * found.residual_start},
          {"residual_uN", 1e6 * found.residual},
          {"noise_uN", 1e6 * found.noise},
          {"misfit", number_or_null(found.misfit)},
          {"misfit_limit", number_or_null(found.misfit_limit)},
          {"fits", found.fits()},
          {"warning", found.fits() ? Json() : Json(warning(chosen.scene.scene, found))},
          {"not_stated", not_stated(chosen.scene.scene)}};
}

// What a reader must know about parameter `i`; empty where it was fitted.
std::string remark(const Identification& found, std::size_t i) {
  const IdentifiedParameter& p = found.parameters[i];
  if (p.told == Told::fitted) return "";
  if (p.told == Told::at_bound)
    return fmt::format("  at its bound ({:.4g} to {:.4g}): start elsewhere with --set", p.lowest,
                       p.highest);
  Eigen::RowVectorXd others = found.correlation.row(static_cast<Eigen::Index>(i)).cwiseAbs();
  others[static_cast<Eigen::Index>(i)] = 0;
  return others.maxCoeff() > kNoted ? "  another parameter can replace it"
         : found.fits()             ? "  the recordings tell nothing about it"
                                    : "  a scene that does not fit tells nothing about it";
}

void print(const Chosen& chosen, const Identification& found) {
  fmt::print("{:<40} {:>12} {:>12} {:>12} {:>12}\n", "parameter", "start", "value", "95 % low",
             "95 % high");
  const auto shown = [](double x) { return number_or("open", "{:.6g}", x); };
  for (std::size_t i = 0; i < found.parameters.size(); ++i) {
    const IdentifiedParameter& p = found.parameters[i];
    fmt::print("{:<40} {:>12.6g} {:>12} {:>12} {:>12}{}\n", p.key, p.start, shown(p.value),
               shown(p.low), shown(p.high), remark(found, i));
  }
  for_each_pair(found, [](const std::string& one, const std::string& other, double r) {
    if (std::abs(r) > kNoted)
      fmt::print("note: {} and {} can hardly be told apart (correlation {:.4f}); hold one fixed\n",
                 one, other, r);
  });
  fmt::print(
      "{} episodes, {} rows; force difference {:.4g} uN at the start, {:.4g} uN fitted; noise "
      "alone would make {:.4g} uN\n",
      chosen.recordings.size(), found.rows, 1e6 * found.residual_start, 1e6 * found.residual,
      1e6 * found.noise);
}

int identify_verb(const IdentifyArguments& a) {
  Provenance provenance;
  const Chosen chosen = choose(a, provenance);
  Identification found;
  std::optional<EndsAfter> heard_late(std::in_place, "step");
  std::optional<Progress> progress_shown(std::in_place, "identifying", 1);
  Progress& progress = *progress_shown;
  try {
    found = identify(chosen.recordings, chosen.scene.scene, a.parameters, a.seed,
                     [&](std::size_t done, std::size_t all) {
                       progress(done, "", all);
                       return !interrupted();
                     });
  } catch (const BadInput& error) {
    end_if_interrupted();
    throw BadInput(a.folder + ": " + error.what());
  }
  progress_shown.reset();
  heard_late.reset();
  if (found.partial) provenance.partial("the best of the identification so far");
  const std::string warned = warning(chosen.scene.scene, found);
  if (!a.output.text() && !warned.empty()) fmt::print(stderr, "warning: {}\n", warned);
  if (a.output.text()) {
    fmt::print("{}{}", provenance.head(), warned.empty() ? "" : "WARNING: " + warned + "\n");
    print(chosen, found);
    fmt::print("{}", provenance.foot());
  }
  Json json = to_json(a, chosen, found);
  for (const auto& [key, value] : json["parameters"].items()) {
    Json row = {{"parameter", key}};
    row.update(value);
    json["table"].push_back(row);
  }
  print_result(a.output, json, "table", provenance);
  return found.partial ? kInterrupted : kDone;
}

}  // namespace

void add_identify(CLI::App& app, Run& run) {
  auto* verb =
      app.add_subcommand("identify", "Fit physical parameters of the scene to recorded forces");
  auto a = std::make_shared<IdentifyArguments>();
  verb->add_option("folder", a->folder, "Folder with the episodes")->required()->type_name("DIR");
  verb->add_option("--parameters", a->parameters, "Which: dotted keys of the scene, with commas")
      ->required()
      ->delimiter(',')
      ->type_name("KEY,KEY,...");
  a->scene.add_to(*verb, "that of the episodes");
  add_seed(*verb, a->seed, "Seed of the episodes that are taken and of the random starts");
  add_output(*verb, a->output);
  add_examples(*verb, {"identify episodes --parameters laws.friction.burgers_nm",
                       "identify episodes --parameters ferrule.bore_diameter_um --set "
                       "ferrule.bore_diameter_um=126.2"});
  verb->callback([a, &run] { run.verb = [a] { return identify_verb(*a); }; });
}

}  // namespace ferrule
