// A System plugin for the real Gazebo: prints the process's CPU time [s] of the iterations between two numbers, and ends.
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <gazebo/gazebo.hh>
#include <unistd.h>

static double Spent() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

class Iterations : public gazebo::SystemPlugin {
  void Load(int, char **) override {
    this->begin = gazebo::event::Events::ConnectWorldUpdateBegin([this](const gazebo::common::UpdateInfo &) {
      if (++this->count == this->first) {
        this->before = Spent();
      } else if (this->count == this->last) {
        std::printf("%.9f\n", Spent() - this->before);
        std::fflush(stdout);
        _exit(0);
      }
    });
  }

  long first = std::atol(std::getenv("FIRST")), last = this->first + std::atol(std::getenv("COUNT")), count = 0;
  double before = 0;
  gazebo::event::ConnectionPtr begin;
};

GZ_REGISTER_SYSTEM_PLUGIN(Iterations)
