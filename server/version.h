// version.h - the program's version and the protocol's.
#ifndef SERVER_VERSION_H
#define SERVER_VERSION_H

#define VERSION_PROGRAM "0.1.0"
#define VERSION_PROTOCOL 1

#endif
