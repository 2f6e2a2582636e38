// Matrices of Eigen as tensors of libtorch, and back.
#pragma once

#include <torch/types.h>

#include <Eigen/Core>

namespace ferrule {

// (columns, rows) of a matrix (rows, columns): what is a column of Eigen's is a row of libtorch's.
inline torch::Tensor to_tensor(const Eigen::MatrixXf& m) {
  return torch::from_blob(const_cast<float*>(m.data()), {m.cols(), m.rows()}, torch::kFloat32)
      .clone();
}

// Not transposed.
inline Eigen::MatrixXf to_matrix(const torch::Tensor& tensor) {
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const torch::Tensor t = tensor.detach().contiguous();
  return Eigen::Map<const RowMajor>(t.data_ptr<float>(), t.size(0), t.size(1));
}

inline Eigen::VectorXf to_vector(const torch::Tensor& tensor) {
  const torch::Tensor t = tensor.detach().contiguous();
  return Eigen::Map<const Eigen::VectorXf>(t.data_ptr<float>(), t.size(0));
}

}  // namespace ferrule
