"""control_toolbox/pid.h: the controller that C++ plugins for ROS 1 use, of a package that Debian does not have."""

__all__ = ["PID"]

PID = """\
/* The PID controller of control_toolbox, by its names; written by libgz. License: Apache License 2.0. */
#ifndef CONTROL_TOOLBOX__PID_H
#define CONTROL_TOOLBOX__PID_H
#include <algorithm>
#include <cmath>
#include <string>

#include <ros/ros.h>

namespace control_toolbox {
class Pid
{
 public:
  /* Gains, limits of the integral's share, and whether the integral itself is limited to them. */
  struct Gains
  {
    Gains(double p, double i, double d, double i_max, double i_min, bool antiwindup = false)
        : p_gain_(p), i_gain_(i), d_gain_(d), i_max_(i_max), i_min_(i_min), antiwindup_(antiwindup)
    {
    }
    Gains() : Gains(0.0, 0.0, 0.0, 0.0, 0.0) {}
    double p_gain_, i_gain_, d_gain_, i_max_, i_min_;
    bool antiwindup_;
  };

  Pid(double p = 0.0, double i = 0.0, double d = 0.0, double i_max = 0.0, double i_min = -0.0, bool antiwindup = false)
      : gains(p, i, d, i_max, i_min, antiwindup)
  {
  }
  void initPid(double p, double i, double d, double i_max, double i_min, bool antiwindup = false)
  {
    this->setGains(p, i, d, i_max, i_min, antiwindup);
    this->reset();
  }
  void initPid(double p, double i, double d, double i_max, double i_min, const ros::NodeHandle &)
  {
    this->initPid(p, i, d, i_max, i_min);
  }
  bool initParam(const std::string &prefix, const bool quiet = false)
  {
    return this->init(ros::NodeHandle(prefix), quiet);
  }
  /* Reads p, i, d, i_clamp or i_clamp_min and i_clamp_max, and antiwindup; false if there is no p. */
  bool init(const ros::NodeHandle &node, const bool quiet = false)
  {
    Gains read;
    if (!node.getParam("p", read.p_gain_))
    {
      if (!quiet)
        ROS_ERROR("No p gain is among the parameters of %s", node.getNamespace().c_str());
      return false;
    }
    double clamp = 0.0;
    node.param("i", read.i_gain_, 0.0);
    node.param("d", read.d_gain_, 0.0);
    node.param("i_clamp", clamp, 0.0);
    node.param("i_clamp_max", read.i_max_, std::abs(clamp));
    node.param("i_clamp_min", read.i_min_, -std::abs(clamp));
    node.param("antiwindup", read.antiwindup_, false);
    this->gains = read;
    this->reset();
    return true;
  }
  void reset() { this->last = this->p_error = this->i_error = this->d_error = this->command = 0.0; }

  void getGains(double &p, double &i, double &d, double &i_max, double &i_min) const
  {
    bool antiwindup;
    this->getGains(p, i, d, i_max, i_min, antiwindup);
  }
  void getGains(double &p, double &i, double &d, double &i_max, double &i_min, bool &antiwindup) const
  {
    p = this->gains.p_gain_;
    i = this->gains.i_gain_;
    d = this->gains.d_gain_;
    i_max = this->gains.i_max_;
    i_min = this->gains.i_min_;
    antiwindup = this->gains.antiwindup_;
  }
  Gains getGains() const { return this->gains; }
  void setGains(double p, double i, double d, double i_max, double i_min, bool antiwindup = false)
  {
    this->gains = Gains(p, i, d, i_max, i_min, antiwindup);
  }
  void setGains(const Gains &values) { this->gains = values; }

  /* The effort for an error, the target minus the state, after a time. */
  double computeCommand(double error, ros::Duration dt)
  {
    const double step = dt.toSec();
    if (!(step > 0.0) || !std::isfinite(error))
      return 0.0;
    const double rate = (error - this->last) / step;
    this->last = error;
    return this->computeCommand(error, rate, dt);
  }
  double computeCommand(double error, double error_dot, ros::Duration dt)
  {
    const double step = dt.toSec();
    this->p_error = error;
    this->d_error = error_dot;
    if (!(step > 0.0) || !std::isfinite(error) || !std::isfinite(error_dot))
      return 0.0;
    const Gains &g = this->gains;
    this->i_error += step * error;
    if (g.antiwindup_ && g.i_gain_ != 0.0)
    {
      const double one = g.i_min_ / g.i_gain_, other = g.i_max_ / g.i_gain_;
      this->i_error = std::clamp(this->i_error, std::min(one, other), std::max(one, other));
    }
    double integral = g.i_gain_ * this->i_error;
    if (!g.antiwindup_)
      integral = std::max(g.i_min_, std::min(integral, g.i_max_));
    return this->command = g.p_gain_ * error + integral + g.d_gain_ * error_dot;
  }
  void setCurrentCmd(double value) { this->command = value; }
  double getCurrentCmd() const { return this->command; }
  void getCurrentPIDErrors(double *pe, double *ie, double *de) const
  {
    *pe = this->p_error;
    *ie = this->i_error;
    *de = this->d_error;
  }

 private:
  Gains gains;
  double last = 0.0, p_error = 0.0, i_error = 0.0, d_error = 0.0, command = 0.0;
};
}  // namespace control_toolbox
#endif
"""
