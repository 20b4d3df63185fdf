// http.h - request heads in, response heads out: the part of HTTP/1.1 that a
// page, its assets and a WebSocket upgrade need (RFC 9112, RFC 6455).
//
// Strict on purpose, because what one program reads leniently another is led
// astray by: lines end with CRLF, no folded header, no blank before a colon,
// one Host in HTTP/1.1, target in origin form ("/...").
// Time limits (408) are the caller's: nothing here knows the time.
// Thread: any (no shared state).
#ifndef PROTOCOL_HTTP_H
#define PROTOCOL_HTTP_H

#include <stdbool.h>
#include <stddef.h>

#include "protocol/bytes.h"

#define HTTP_HEAD_MAX 8192   // bytes of a request head, blank line included
#define HTTP_TARGET_MAX 2048 // bytes
#define HTTP_HEADERS_MAX 64  // header lines
#define HTTP_ACCEPT_SIZE 29  // of a Sec-WebSocket-Accept, with its NUL

enum http_result { HTTP_MORE, HTTP_ONE, HTTP_BAD };

struct http_header {
    struct span name, value; // value without blanks at its ends
};

struct http_request {   // spans point into the bytes parsed
    struct span method; // "GET"
    struct span target; // "/ws?x=1"
    struct span path;   // target up to "?"
    struct span query;  // after "?"; may be empty
    int minor;          // HTTP/1.minor: 0 or 1
    bool keep_alive;    // what the client wants (version and Connection)
    bool has_body;      // Content-Length above 0 or a Transfer-Encoding
    int header_count;
    struct http_header headers[HTTP_HEADERS_MAX];
    size_t size;     // HTTP_ONE: bytes of the head, the blank line included
    int status;      // HTTP_BAD: 400, 414, 431 or 505; answer it and close
    const char *why; // HTTP_BAD: a constant text
};

// `in` is all that was received and not yet used.  Parses from the start each
// time; an over-long target or head is HTTP_BAD as soon as it shows.
enum http_result http_parse(struct http_request *r, struct span in);

// 0, or the status with which a well-formed request is to be refused: 405 for
// any method but GET and HEAD (send `Allow: GET, HEAD`), 413 for a body.  The
// connection is to be closed after either.
int http_refuse(const struct http_request *r);

// The first header of that name (any case), or NULL.
const struct span *http_header(const struct http_request *r, const char *name);
// True when a comma list in any header of that name has the token (any case).
bool http_has_token(const struct http_request *r, const char *name,
                    const char *token);
bool http_is(struct span text, const char *want);        // exactly
bool http_is_nocase(struct span text, const char *want); // ASCII case ignored

// Host is in the list, a NULL-terminated one of "name:port", compared exactly
// but for ASCII case.  False when there is no Host.
bool http_host_allowed(const struct http_request *r, const char *const *hosts);
// Origin is in the list ("http://name:port"), compared exactly ("null" never
// matches); *absent says that there was none, and the result is then false.
bool http_origin_allowed(const struct http_request *r,
                         const char *const *origins, bool *absent);

// 101 when the request is a good WebSocket upgrade, and *key is its key; 0
// when it asks for no upgrade; else the refusal: 400, 405 (not GET), 426
// (version not 13, send `Sec-WebSocket-Version: 13`).
int http_upgrade(const struct http_request *r, struct span *key);
void http_accept(struct span key, char out[HTTP_ACCEPT_SIZE]);

struct http_response { // zero default: no body, connection closes
    int status;
    const char *type; // media type of the body, NULL: none
    size_t length;    // of the body; not written for 101 and 304
    bool keep_alive;
    const char *extra; // further header lines, each with its CRLF, or NULL
};

// Appends a response head with its blank line and the headers that every
// answer has (nosniff, no-referrer, content security policy, resource policy,
// no-store).  With status 101, Connection and Upgrade are those of a WebSocket;
// give Sec-WebSocket-Accept in `extra`.
void http_respond(struct buf *out, const struct http_response *r);
// The whole 101 answer.
void http_respond_upgrade(struct buf *out, struct span key);
// A whole answer with one line of plain text as its body (left out when
// head_only); adds Allow to 405, Sec-WebSocket-Version to 426, Retry-After to
// 503.  It announces that the connection closes.
void http_respond_error(struct buf *out, int status, const char *text,
                        bool head_only);

const char *http_reason(int status); // "Not Found"; "" when unknown

#endif
