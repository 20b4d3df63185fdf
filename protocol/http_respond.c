// http_respond.c - response heads.  The headers that guard the page are the
// same on every answer, so that none can be forgotten.
#include "protocol/http.h"

#include <string.h>

#include "protocol/digest.h"

// `blob:` for pictures that the page has decoded; everything else only from
// where the page came from, and nobody may frame it.
static const char guard[] =
    "Content-Security-Policy: default-src 'self'; img-src 'self' blob:; "
    "connect-src 'self'; frame-ancestors 'none'\r\n"
    "X-Content-Type-Options: nosniff\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n"
    "Cache-Control: no-store\r\n";

const char *http_reason(int status)
{
    static const struct {
        int status;
        const char *reason;
    } table[] = {
        {101, "Switching Protocols"},
        {200, "OK"},
        {304, "Not Modified"},
        {400, "Bad Request"},
        {403, "Forbidden"},
        {404, "Not Found"},
        {405, "Method Not Allowed"},
        {408, "Request Timeout"},
        {413, "Content Too Large"},
        {414, "URI Too Long"},
        {421, "Misdirected Request"},
        {426, "Upgrade Required"},
        {431, "Request Header Fields Too Large"},
        {500, "Internal Server Error"},
        {503, "Service Unavailable"},
        {505, "HTTP Version Not Supported"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        if (table[i].status == status)
            return table[i].reason;
    return "";
}

void http_respond(struct buf *out, const struct http_response *r)
{
    bool upgrade = r->status == 101;
    buf_printf(out, "HTTP/1.1 %d %s\r\n", r->status, http_reason(r->status));
    buf_text(out, guard);
    if (upgrade)
        buf_text(out, "Upgrade: websocket\r\nConnection: Upgrade\r\n");
    else
        buf_printf(out, "Connection: %s\r\n",
                   r->keep_alive ? "keep-alive" : "close");
    if (r->type)
        buf_printf(out, "Content-Type: %s\r\n", r->type);
    if (!upgrade && r->status != 304)
        buf_printf(out, "Content-Length: %zu\r\n", r->length);
    if (r->extra)
        buf_text(out, r->extra);
    buf_text(out, "\r\n");
}

// RFC 6455, section 4.2.2: the key and a fixed identifier, hashed.
void http_accept(struct span key, char out[HTTP_ACCEPT_SIZE])
{
    static const char identifier[] = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
    unsigned char text[64 + sizeof identifier], hash[20];
    size_t size = key.size < 64 ? key.size : 64;
    if (size > 0)
        memcpy(text, key.data, size);
    memcpy(text + size, identifier, sizeof identifier - 1);
    digest_sha1((struct span){text, size + sizeof identifier - 1}, hash);
    digest_base64(hash, sizeof hash, out);
}

void http_respond_upgrade(struct buf *out, struct span key)
{
    char accept[HTTP_ACCEPT_SIZE];
    struct buf extra = {0};
    http_accept(key, accept);
    buf_printf(&extra, "Sec-WebSocket-Accept: %s\r\n", accept);
    buf_byte(&extra, 0);
    http_respond(out, &(struct http_response){
                          .status = 101, .extra = (const char *)extra.data});
    buf_finish(&extra);
}

void http_respond_error(struct buf *out, int status, const char *text,
                        bool head_only)
{
    const char *extra = status == 405   ? "Allow: GET, HEAD\r\n"
                        : status == 426 ? "Upgrade: websocket\r\n"
                                          "Sec-WebSocket-Version: 13\r\n"
                        : status == 503 ? "Retry-After: 5\r\n"
                                        : NULL;
    http_respond(out,
                 &(struct http_response){.status = status,
                                         .type = "text/plain; charset=utf-8",
                                         .length = strlen(text) + 1,
                                         .extra = extra});
    if (!head_only)
        buf_printf(out, "%s\n", text);
}
