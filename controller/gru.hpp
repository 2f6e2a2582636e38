// A gated recurrent unit (Cho et al. 2014, in the form that cuDNN and PyTorch have): what a network
// remembers of a sequence of inputs x.
//
//   r = s(W_r x + b_r + U_r h + c_r)       s(a) = (1 + tanh(a/2))/2
//   u = s(W_u x + b_u + U_u h + c_u)
//   n = tanh(W_n x + b_n + r (U_n h + c_n))
//   h <- (1 - u) n + u h                   products of r, u and 1 - u element by element
#pragma once

#include <Eigen/Core>

namespace ferrule {

struct Gru {
  // The rows of r, then u, then n.
  Eigen::MatrixXf input_weight;             // W (3 units, inputs)
  Eigen::MatrixXf memory_weight;            // U (3 units, units)
  Eigen::VectorXf input_bias, memory_bias;  // b, c (3 units)

  Eigen::Index units() const noexcept { return memory_weight.cols(); }
};

class GruState {
 public:
  explicit GruState(Eigen::Index units)
      : h_(Eigen::VectorXf::Zero(units)), from_input_(3 * units), from_memory_(3 * units) {}

  const Eigen::VectorXf& h() const noexcept { return h_; }

  // Does not allocate.
  void take_in(const Gru& gru, const Eigen::VectorXf& x) noexcept {
    const Eigen::Index m = h_.size();
    from_input_ = gru.input_bias;
    from_input_.noalias() += gru.input_weight * x;
    from_memory_ = gru.memory_bias;
    from_memory_.noalias() += gru.memory_weight * h_;
    auto gates = from_input_.head(2 * m).array();
    gates = 0.5f + 0.5f * (0.5f * (gates + from_memory_.head(2 * m).array())).tanh();
    const auto r = from_input_.head(m).array(), u = from_input_.segment(m, m).array();
    auto n = from_input_.tail(m).array();
    n = (n + r * from_memory_.tail(m).array()).tanh();
    h_ = (1 - u) * n + u * h_.array();
  }

 private:
  Eigen::VectorXf h_, from_input_, from_memory_;
};

}  // namespace ferrule
