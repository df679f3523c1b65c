// The node of plugins for ROS 1: they expect that Gazebo has made one. License: Apache License 2.0.
//
// libgz is built without ROS; a plugin that uses it brings roscpp along, whose functions are found by name.
#include <dlfcn.h>

#include "bridge.hh"

namespace {
const char INIT[] =
    "_ZN3ros4initERKSt3mapINSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEES6_St4lessIS6_ESaISt4pairIKS6_S6_EEERSA_j";
const char IS_INITIALIZED[] = "_ZN3ros13isInitializedEv", SPIN[] = "_ZN3ros4spinEv", START[] = "_ZN3ros5startEv";
const uint32_t NO_SIGINT_HANDLER = 1;

template <class F>
F *function(void *plugin, const char *name)
{
  return reinterpret_cast<F *>(dlsym(plugin, name));
}
}  // namespace

/* Starts the node of a process, and a thread for its callbacks; whether there is one now. */
extern "C" int libgz_start_roscpp(void *plugin, const char *name)
{
  auto *init = function<void(const std::map<std::string, std::string> &, const std::string &, uint32_t)>(plugin, INIT);
  auto *initialized = function<bool()>(plugin, IS_INITIALIZED);
  auto *start = function<void()>(plugin, START), *spin = function<void()>(plugin, SPIN);
  Dl_info place;
  if (!init || !initialized || !start || !spin || dladdr(reinterpret_cast<void *>(init), &place) == 0)
    return 0;
  if (initialized())
    return 1;
  dlopen(place.dli_fname, RTLD_NOW | RTLD_NODELETE);  // its threads outlive the plugin
  libgz::Unlocked unlocked;
  init({}, name, NO_SIGINT_HANDLER);
  start();
  std::thread(spin).detach();
  return 1;
}
