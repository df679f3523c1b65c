/* Errors and messages of the library, in the form of the old library: "file:line text". */

#ifndef LIBGZ_ERROR_H
#define LIBGZ_ERROR_H

#define GZ_REPORT(print_at, ...) gz_error_report(print_at, __FILE__, __LINE__, __VA_ARGS__)
#define GZ_ERROR(...) GZ_REPORT(GZ_ALWAYS, __VA_ARGS__)
#define GZ_MESSAGE(level, ...) GZ_REPORT(level, __VA_ARGS__)

enum { GZ_ALWAYS = -1, GZ_SESSION = 1, GZ_FILES = 5, GZ_PATH_SIZE = 128 };

/* Keep a text for gz_error_str, and print it if it is an error or its level is enabled. */
void gz_error_report(int level, const char *file, int line, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* $TMP/gazebo-$USER-<server id>, as servers and clients compute it. */
void gz_server_path(char path[GZ_PATH_SIZE], int server_id);

#endif
