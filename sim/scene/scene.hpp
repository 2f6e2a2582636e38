// A scene: the world, where insertions start, what counts as success, and the two ranges that scale
// the hand to the tip. One JSON file (data/README.md describes every key); SI inside.
#pragma once

#include <array>
#include <bitset>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/json_fields.hpp"
#include "sim/scene/drawn_numbers.hpp"
#include "sim/scene/force_sensor.hpp"
#include "sim/scene/joint.hpp"
#include "sim/scene/world_parameters.hpp"

namespace ferrule {

// Where the fibre's end rests at the start of a trial. That of a curled fibre (fibre.curl_radius_m)
// lies aside and tilts besides: this is where that of a straight one would be.
struct InsertionStart {
  double distance;   // x of the end, outside the bore [m], >= 0
  Vector2d lateral;  // y and z [m]
  Vector2d tilt;     // [rad]
  // Where a simulated operator sees the bore's axis, y and z, to which he steers before the entrance
  // [m]; empty: he keeps the line that he starts on.
  std::optional<Vector2d> vision;
  // What they are drawn from where the scene states nothing more: mean of `lateral` [m], and
  // standard deviations of each number, >= 0.
  Vector2d lateral_mean;
  double lateral_sd;  // [m]
  double tilt_sd;     // [rad]
  double vision_sd;   // [m]
};

struct Limits {
  double force;  // largest force at the holder, weight apart [N], > 0
  double speed;  // largest speed commanded [m/s], > 0
  double time;   // longest trial [s], > 0
  double proof_stress = std::numeric_limits<double>::infinity();  // of bending [Pa], > 0
};

struct Success {
  double depth;  // inserted length [m], > 0
  // Most that the joint with an ideal partner may lose then [dB], > 0.
  double loss_dB = std::numeric_limits<double>::infinity();
};

// How the holder does not move quite as the hand means it to (insertion/imperfect_hand.hpp), and how
// the fibre does not lie in it quite as it should: added to where it starts.
struct HandErrors {
  double gain = 1;       // the holder's motion over that of the hand [-], > 0
  double delay = 0;      // [s], >= 0
  double smoothing = 0;  // time constant of a first-order lag [s], >= 0
  double dead_zone = 0;  // speed below which the hand does not move the holder [m/s], >= 0
  Vector2d grasp = Vector2d::Zero();       // in y and z [m]
  Vector2d grasp_tilt = Vector2d::Zero();  // [rad]

  bool none() const noexcept { return gain == 1 && delay == 0 && smoothing == 0 && dead_zone == 0; }
};

// Ranges of (14) and (15) of the paper.
struct ScalingRanges {
  double hand_range, tip_range;  // x_s and x_m [m], > 0
  double hand_force, tip_force;  // f_s and f_m [N], > 0
};

// The form of a force law: as the paper prints it, or corrected (sim/laws/laws.hpp).
enum class Form { printed, corrected };

// What chance decides of a trial besides: what the force sensor adds, and the particle.
inline constexpr std::array kDrawnBesides = {"sensor", "laws.particle"};

struct Scene {
  std::string name;
  WorldParameters parameters;  // what it states of the world
  World world;                 // and the world that follows
  InsertionStart start;
  ForceSensorModel sensor;
  HandErrors hand;
  Limits limits;
  Success success;
  Joint joint;
  ScalingRanges scaling;
  bool cue = false;  // the operator's window shows which way to correct; nothing else knows of it
  // "accuracy": what the scene wants of a model that leaves out what it does not need. Reading a
  // scene does not apply it; planned() of sim/analysis/plan.hpp does.
  std::optional<double> accuracy;
  // What chance decides in each trial. All of the above has it at its centre, or as the document
  // states it besides; draw_scene of draw.hpp gives a trial's scene, which has none. Where the
  // centres cannot be together (a fibre as wide as the bore), it is as in a trial in which the
  // numbers can.
  std::vector<DrawnNumber> drawn;
  // What it came to in a trial's scene.
  std::vector<DecidedNumber> decided;
  // Which numbers of scene_keys.hpp its file states.
  std::bitset<192> states;
  // The file with its settings, before chance decides.
  std::shared_ptr<const Json> stated;

  // The scene as resolved: the file with its settings, and with what chance decided. Parsing it
  // gives this scene again; what is changed above alone it does not have.
  Json document() const;
};

// Throws BadInput: "FILE: KEY = VALUE: RULE".
Scene parse_scene(const Json& document, const std::string& file);

// `name_or_file`: a file, or the bare name of a scene that ships with the program; it may extend
// another one (sim/scene/extends.hpp). `settings` are
// "dotted.key=value" (sim/scene/setting.hpp). Throws BadInput, FileTrouble.
Scene load_scene(const std::string& name_or_file, const std::vector<std::string>& settings = {});

// Refuses what a scene that is written must not be, though a recording of before may: a success
// depth beyond the fibre that is free to go in, or a free length beyond the length that is handled.
// Throws BadInput.
void refuse_contradictions(const Scene& scene, const std::string& file);

// The file of a scene, `name_or_file` as above. Throws FileTrouble.
std::string scene_file(const std::string& name_or_file);

// Names of the scenes that ship with the program, sorted.
std::vector<std::string> shipped_scenes();

// Changes the form of all laws of a scene document. Throws BadInput naming the laws that do not
// exist in that form (the paper prints no drag and no meniscus).
void set_form(Json& document, Form form, const std::string& file);

// A scene whose numbers can be changed one by one.
class VariableScene {
 public:
  explicit VariableScene(const Scene& scene);

  // The number of that dotted key, in the unit of the file; empty: there is none.
  std::optional<double> number(const std::string& key) const;
  // Sets it; the key is there. The numbers are not consistent with one that is not allowed.
  void set(const std::string& key, double value);
  // Are the numbers, as set, those of a scene?
  bool consistent() const;
  // The world of the numbers as set, which are consistent.
  World world() const { return make_world(scene_.parameters); }

 private:
  Scene scene_;
  std::map<std::string, double> numbers_;  // in the unit of the file
};

}  // namespace ferrule
