// log.h - lines on stderr for who runs the daemon.
// Thread: any.
#ifndef SERVER_LOG_H
#define SERVER_LOG_H

// One line "glintd: ..."; control characters become blanks, so that a client
// cannot write lines of its own.
void log_line(const char *fmt, ...) __attribute__((format(printf, 1, 2)));

#endif
