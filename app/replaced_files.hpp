// What a command writes must not take the place of what it reads.
#pragma once

#include <string>
#include <vector>

namespace ferrule {

// Throws BadInput where a file that the command of these words writes is one that it reads, under
// whatever name, or that it writes by another option. `job`: the folder of a job that it reads,
// too; may be empty.
void refuse_to_replace(const std::vector<std::string>& words, const std::string& job);

}  // namespace ferrule
