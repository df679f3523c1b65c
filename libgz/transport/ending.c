/* Ends a process whose Python code cannot run, because native code keeps the interpreter lock.
 *
 * A thread that never needs that lock reads the numbers of signals from a pipe, and passes them on to another one, which
 * Python's watchdog reads. If that has not ended the process some time after the second signal, the thread does it: it
 * removes the files and semaphores of all servers of the process.
 */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ipc.h>
#include <sys/sem.h>
#include <time.h>
#include <unistd.h>

enum {
    PERIOD = 500, /* [ms] between two looks at the watchdog */
    SHORT = 50,   /* [ms] the same, after a signal */
    LATEST = 900, /* [ms] after the second signal: more than the watchdog takes */
    LONG = 5000,  /* [ms] without a beat of the watchdog, until that is reported */
};

struct server {
    struct server *next;
    int semaphores;
    char path[];
};

/* Functions of pthread.h, from the process: linked ones would need a C library as new as that of the build. */
struct threads {
    int (*create)(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    int (*join)(pthread_t, void **);
    int (*kill)(pthread_t, int);
};

_Atomic int64_t gz_ending_beat; /* the watchdog counts here */

static atomic_flag busy = ATOMIC_FLAG_INIT;
static struct server *servers; /* of this process; changed while it is busy */
static pid_t owner;            /* of them: a forked child has none */
static pthread_t thread;
static int from, to, report;
static pthread_t main_thread; /* that is shown in a report */
static struct threads calls;

static int64_t now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (int64_t) time.tv_sec * 1000 + time.tv_nsec / 1000000;
}

static void take(void)
{
    while (atomic_flag_test_and_set(&busy))
        sched_yield();
}

static void print(const char *text)
{
    if (write(STDERR_FILENO, text, strlen(text)) < 0)
        return; /* nobody reads it */
}

/* Remove a server's directory with the files in it. */
static void remove_directory(const char *path)
{
    DIR *directory = opendir(path);
    if (directory == NULL)
        return;
    for (struct dirent *entry; (entry = readdir(directory)) != NULL;)
        unlinkat(dirfd(directory), entry->d_name, 0);
    closedir(directory);
    rmdir(path);
}

static void end(int number)
{
    if (owner == getpid() && !atomic_flag_test_and_set(&busy))
        for (struct server *server = servers; server != NULL; server = server->next) {
            remove_directory(server->path);
            semctl(server->semaphores, 0, IPC_RMID);
        }
    print("libgz: ended at once: second signal, ");
    print(number == SIGINT ? "SIGINT\n" : number == SIGTERM ? "SIGTERM\n" : "SIGHUP\n");
    _exit(128 + number);
}

static void *run(void *unused)
{
    (void) unused;
    unsigned char bytes[64];
    int signals[2] = {0, 0}, count = 0, reported = 0;
    int64_t second = 0, last = now(), silent = 0, beat = atomic_load(&gz_ending_beat);
    for (;;) {
        struct pollfd wanted = {.fd = from, .events = POLLIN};
        ssize_t got = poll(&wanted, 1, count > 0 ? SHORT : PERIOD) > 0 ? read(from, bytes, sizeof bytes) : 0;
        if (got > 0 && write(to, bytes, (size_t) got) < 0)
            got = 0; /* the pipe is full of signals */
        for (ssize_t i = 0; i < got; i++) {
            if (bytes[i] == 0)
                return NULL;
            if ((bytes[i] == SIGINT || bytes[i] == SIGTERM || bytes[i] == SIGHUP) && count < 2)
                signals[count++] = bytes[i];
        }
        int64_t time = now(), passed = time - last;
        last = time;
        if (count == 2) {
            second = second != 0 ? second : time;
            if (time - second >= LATEST)
                end(signals[1]);
        }
        /* A process that was suspended was not silent for as long as that. */
        silent += passed < 2 * PERIOD ? passed : 2 * PERIOD;
        int64_t newest = atomic_load(&gz_ending_beat);
        if (newest != beat) {
            beat = newest;
            silent = reported = 0;
        } else if (silent >= LONG && !reported) {
            reported = 1;
            print("libgz: native code has kept Python's interpreter lock for 5 s; a second signal ends the process. ");
            if (report == 0 || calls.kill(main_thread, report) != 0)
                print("\n");
        }
    }
}

/* Begin to pass on signals.
 *
 * pipe_in, pipe_out: where they are read, and written.
 * shown: the thread to which `number`, a signal whose handler prints its stack, is sent for a report; 0: there is none.
 *
 * The calling thread blocks all signals, so that the new one handles none.
 *
 * 0, or an error number. */
int gz_ending_start(int pipe_in, int pipe_out, unsigned long shown, int number, const struct threads *functions)
{
    from = pipe_in, to = pipe_out, main_thread = (pthread_t) shown, report = number, calls = *functions;
    fcntl(to, F_SETFL, O_NONBLOCK);
    return calls.create(&thread, NULL, run, NULL);
}

/* Wait for the end of the thread, to which a 0 was written. */
void gz_ending_join(void)
{
    calls.join(thread, NULL);
}

/* Forget the server of a directory, which was removed. */
void gz_ending_forget(const char *path)
{
    take();
    for (struct server **at = &servers; *at != NULL; at = &(*at)->next)
        if (strcmp((*at)->path, path) == 0) {
            struct server *removed = *at;
            *at = removed->next;
            free(removed);
            break;
        }
    atomic_flag_clear(&busy);
}

/* Note what a server of this process leaves behind: a directory with files, and a set of semaphores. */
void gz_ending_note(const char *path, int semaphores)
{
    gz_ending_forget(path);
    struct server *server = malloc(sizeof *server + strlen(path) + 1);
    if (server == NULL)
        return;
    server->semaphores = semaphores;
    strcpy(server->path, path);
    take();
    if (owner != getpid())
        servers = NULL;
    owner = getpid();
    server->next = servers;
    servers = server;
    atomic_flag_clear(&busy);
}
