// ferrule contact: the adhesive contact of one lambda (Maugis 1992), dimensionless.
#include <fmt/format.h>

#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/plot.hpp"
#include "app/validators.hpp"
#include "app/verbs.hpp"
#include "sim/laws/maugis.hpp"

namespace ferrule {
namespace {

struct ContactArguments {
  double lambda = 4;
  std::string radius, plot;
  bool curve = false;
  Output output;
};

std::vector<double> parse_radii(const std::string& text) {
  std::vector<double> radii;
  std::string part;
  for (std::size_t i = 0; i <= text.size(); ++i) {
    if (i < text.size() && text[i] != ',') {
      part += text[i];
      continue;
    }
    for (const double radius : parse_range(part, "--radius")) {
      if (!(radius >= 1e-6 && radius <= 1e6))
        throw BadInput("--radius " + text + ": must be from 1e-6 to 1e6");
      radii.push_back(radius);
    }
    part.clear();
  }
  return radii;
}

Json to_json(const MaugisPoint& p) {
  return {{"A", p.A}, {"m", number_or_null(p.m)}, {"P", p.P}, {"D", p.D}};
}

Plot curve_plot(const MaugisCurve& curve) {
  const std::vector<MaugisPoint> points = curve.points(3000);
  Axes axes{"penetration D", "force P", false, false, {}};
  Series whole{"all equilibria", {}, {}};
  for (const MaugisPoint& p : points) {
    if (p.D > 4) continue;
    whole.x.push_back(p.D);
    whole.y.push_back(p.P);
  }
  axes.series.push_back(whole);
  const double from = curve.begins(1) - 0.5, to = 4;
  for (const bool out : {false, true}) {
    Series way{out ? "retreat" : "approach", {}, {}};
    int branch = out ? curve.branches() : 0;
    for (int i = 0; i <= 4000; ++i) {
      const double D = out ? to - (to - from) * i / 4000 : from + (to - from) * i / 4000;
      const MaugisCurve::Value v = curve.at(D, branch);
      branch = v.branch;
      way.x.push_back(D);
      way.y.push_back(v.P);
    }
    axes.series.push_back(way);
  }
  return {fmt::format("Adhesive contact, lambda = {:g}", curve.lambda()), {axes}};
}

Json to_json(const MaugisCurve& curve, const std::vector<MaugisPoint>& points) {
  Json branches = Json::array();
  for (int b = 1; b <= curve.branches(); ++b)
    branches.push_back({{"D_begins", curve.begins(b)}, {"D_ends", number_or_null(curve.ends(b))}});
  return {{"lambda", curve.lambda()},
          {"D_attaches", curve.attaches()},
          {"D_detaches", curve.begins(1)},
          {"pull_off_P", curve.pull_off_force()},
          {"branches", branches},
          {"rows", json_list(points, [](const MaugisPoint& p) { return to_json(p); })}};
}

void print(const MaugisCurve& curve, const std::vector<MaugisPoint>& points) {
  if (!points.empty()) fmt::print("{:>14} {:>14} {:>14} {:>14}\n", "A", "m", "P", "D");
  for (const MaugisPoint& p : points)
    fmt::print("{:14.9g} {:14.9g} {:14.9g} {:14.9g}\n", p.A, p.m, p.P, p.D);
  fmt::print("approaching it attaches at D = {:.6g}, retreating it lets go at D = {:.6g}\n",
             curve.attaches(), curve.begins(1));
  fmt::print("largest attraction P = {:.6g} (-2 for DMT, -1.5 for JKR)\n", curve.pull_off_force());
}

int contact_verb(const ContactArguments& a) {
  const MaugisCurve curve(a.lambda);
  if (a.radius.empty() && !a.curve && a.plot.empty())
    throw BadInput("contact: give --radius, --curve or --plot");
  std::vector<MaugisPoint> points;
  if (!a.radius.empty())
    for (const double radius : parse_radii(a.radius)) {
      end_if_interrupted();
      points.push_back(maugis_at_radius(a.lambda, radius));
    }
  if (a.curve)
    for (const MaugisPoint& p : curve.points(300)) points.push_back(p);
  if (!a.plot.empty()) write_plot(a.plot, curve_plot(curve));
  if (a.output.text()) {
    print(curve, points);
    fmt::print("{}", Provenance().foot());
  }
  print_result(a.output, to_json(curve, points), "rows", {});
  return kDone;
}

}  // namespace

void add_contact(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("contact", "Adhesion curve P(D), A and m for a lambda");
  auto a = std::make_shared<ContactArguments>();
  verb->add_option("--lambda", a->lambda, "Maugis parameter")
      ->capture_default_str()
      ->check(number_between(0.01, 100));
  verb->add_option("--radius", a->radius, "Contact radii A")
      ->type_name("A[,A...]|FROM:TO:COUNT[:log]");
  verb->add_flag("--curve", a->curve, "Points along the whole curve, unstable parts too");
  add_plot(*verb, a->plot, "Draw P(D) with its branches and jumps");
  add_output(*verb, a->output);
  add_examples(*verb, {"contact --lambda 0.3 --radius 0.5:2:4",
                       "contact --lambda 1 --curve --plot curve.svg"});
  verb->callback([a, &run] { run.verb = [a] { return contact_verb(*a); }; });
}

}  // namespace ferrule
