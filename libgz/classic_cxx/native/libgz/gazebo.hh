/* The whole API; each header of classic includes this. License: Apache License 2.0. */
#ifndef LIBGZ_GAZEBO_HH
#define LIBGZ_GAZEBO_HH
#ifndef Q_MOC_RUN  // Qt's moc reads the plugin's own headers only
/* What Gazebo's headers bring along, most of it by boost's network library: plugins use it without naming it. */
#include <dirent.h>
#include <float.h>
#include <inttypes.h>
#include <limits.h>
#include <net/if.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <semaphore.h>
#include <signal.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/timerfd.h>
#include <sys/uio.h>
#include <sys/un.h>
#include <termios.h>

#include <boost/unordered_map.hpp>
#include <boost/unordered_set.hpp>
#include <csignal>
#include <future>

#include "gazebo/libgz/classes.hh"
#include "gazebo/libgz/functions.hh"
#include "gazebo/libgz/introspection.hh"
#include "gazebo/libgz/ode.hh"
#include "gazebo/libgz/surface.hh"
#include "gazebo/libgz/uri.hh"

/* Gazebo's macros of its timers measure nothing, unless it is built for that. */
#define DIAG_TIMER_START(name) ((void)0)
#define DIAG_TIMER_LAP(name, prefix) ((void)0)
#define DIAG_TIMER_STOP(name) ((void)0)
#endif
#endif
