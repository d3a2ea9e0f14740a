// Plans with the navigation function of nav2 (`nav2_navfn_planner`, navfn.hpp and navfn.cpp), for the example
// navfn.rs beside this file, which states the commands and the form of all three files.
//
// navfn.cpp needs two headers: `rclcpp/rclcpp.hpp` with the macros RCLCPP_DEBUG and RCLCPP_WARN, and
// `nav2_core/planner_exceptions.hpp` with the class nav2_core::PlannerCancelled.

#include <cstdio>
#include <ctime>
#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "nav2_navfn_planner/navfn.hpp"

int main(int count, char ** arguments)
{
  if (count != 4) {
    std::fprintf(stderr, "usage: navfn COSTS.pgm PAIRS.txt RESULTS.txt\n");
    return 2;
  }
  std::ifstream picture(arguments[1], std::ios::binary);
  std::string magic;
  int width = 0, height = 0, most = 0;
  picture >> magic >> width >> height >> most;
  picture.get();
  std::vector<unsigned char> costs(static_cast<size_t>(width) * height);
  picture.read(reinterpret_cast<char *>(costs.data()), costs.size());
  if (!picture || magic != "P5") {
    std::fprintf(stderr, "%s is no map of costs\n", arguments[1]);
    return 1;
  }
  std::ifstream pairs(arguments[2]);
  std::ofstream results(arguments[3]);
  nav2_navfn_planner::NavFn planner(width, height);
  int start[2], goal[2];
  while (pairs >> start[0] >> start[1] >> goal[0] >> goal[1]) {
    // The calls of NavfnPlanner::makePlan, which plans from the goal's side.
    const std::clock_t begin = std::clock();
    planner.setNavArr(width, height);
    planner.setCostmap(costs.data(), true, false);
    planner.setStart(goal);
    planner.setGoal(start);
    planner.calcNavFnDijkstra([] { return false; }, true);
    const int length = planner.calcPath(4 * std::max(width, height));
    results << 1000.0 * (std::clock() - begin) / CLOCKS_PER_SEC;
    for (int at = length; at-- > 0;) {
      results << ' ' << planner.getPathX()[at] + 0.5 << ' ' << planner.getPathY()[at] + 0.5;
    }
    results << '\n';
  }
  return results ? 0 : 1;
}
