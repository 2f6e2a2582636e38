// Named arrays of 32-bit floats in a safetensors file, which many programs read:
//   8 bytes   length of the header, little endian
//   header    JSON {"NAME": {"dtype": "F32", "shape": [...], "data_offsets": [from, to]}, ...,
//                   "__metadata__": {"KEY": "TEXT", ...}}
//   data      the arrays one after the other, row-major, little endian; offsets count from here
#pragma once

#include <map>
#include <string>
#include <vector>

namespace ferrule {

struct Tensor {
  std::vector<std::size_t> shape;
  std::vector<float> values;  // row-major, as many as the product of the shape
};
using Tensors = std::map<std::string, Tensor>;

// The bytes of such a file.
std::string safetensors_bytes(const Tensors& tensors,
                              const std::map<std::string, std::string>& metadata);

// From the bytes; `file` is for messages. The file is taken as hostile: its numbers are checked
// before they are used. Throws BadInput naming the array: header cut off or not such JSON, an array
// of another type, with a shape that is not its size, beyond the data, over another or leaving a
// hole, or with a number that is not finite.
Tensors parse_safetensors(const std::string& bytes, const std::string& file);

}  // namespace ferrule
