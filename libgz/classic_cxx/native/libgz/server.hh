/* Functions of namespace gazebo itself, which hide functions of POSIX such as shutdown: only gazebo.hh has them.
 * License: Apache License 2.0.
 */
#ifndef LIBGZ_SERVER_HH
#define LIBGZ_SERVER_HH
#include "gazebo/libgz/gazebo.hh"

namespace gazebo {
void printVersion();
void addPlugin(const std::string &file);
bool setupServer(int argc = 0, char **argv = 0);
bool setupServer(const std::vector<std::string> &arguments);
physics::WorldPtr loadWorld(const std::string &file);
void runWorld(physics::WorldPtr world, unsigned int iterations);
bool shutdown();
}  // namespace gazebo
#endif
