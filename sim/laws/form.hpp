// The form of a force law: as the paper prints it, or as the literature it builds on has it.
// A scene chooses the form law by law; nothing outside the laws depends on the choice.
#pragma once

namespace ferrule {

enum class Form { printed, corrected };

}  // namespace ferrule
