// What a page says to the program: one JSON object a message, of at most kMostMessage bytes.
//
//   {"type":"hand","v":[x,y,z],"buttons":n,"seq":k}   how the hand moves, of full deflection, each
//                                                     cut to [-1, 1], in the frame of
//                                                     sim/geometry/pose.hpp
//   {"type":"start"} {"type":"stop"} {"type":"discard"} {"type":"rate","stars":1..5}
//   {"type":"fit","episodes":[file names]}            these alone
//   {"type":"fit","but":[file names]}                 all but these; without names all
//   {"type":"insert"}                                 with the controller that was fitted last
//   {"type":"trainee","name":text}                    who makes the next tries; empty: nobody named
// Keys beside these are left unread.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace ferrule {

inline constexpr std::size_t kMostMessage = 4096;

struct HandMessage {
  std::array<double, 3> velocity;  // -1 to 1
  std::uint32_t buttons = 0, sequence = 0;
};
struct StartMessage {};
struct StopMessage {};
struct DiscardMessage {};
struct RateMessage {
  int stars;  // 1 to 5
};
struct FitMessage {
  std::vector<std::string> episodes;  // empty: all of the scene
  std::vector<std::string> but;       // and of these none
};
struct InsertMessage {};
struct TraineeMessage {
  std::string name;  // a line of at most kMostName characters
};
inline constexpr std::size_t kMostName = 100;

using Message = std::variant<HandMessage, StartMessage, StopMessage, DiscardMessage, RateMessage,
                             FitMessage, InsertMessage, TraineeMessage>;

// Throws BadInput.
Message parse_message(std::string_view text);

}  // namespace ferrule
