// websocket.c - takes a client's frames apart (RFC 6455, section 5).  Replies,
// time and the closing handshake are the caller's.
#include "protocol/websocket.h"

#include <string.h>

#include "protocol/utf8.h"

enum phase { PHASE_HEAD, PHASE_PAYLOAD, PHASE_OVER };

void websocket_init(struct websocket *w)
{
    *w = (struct websocket){.head_need = 2};
}

void websocket_finish(struct websocket *w)
{
    buf_finish(&w->message);
}

static enum websocket_event bad(struct websocket *w, int code, const char *why)
{
    w->phase = PHASE_OVER;
    w->code = code;
    w->why = why;
    w->payload = (struct span){w->control, 0};
    return WEBSOCKET_BAD;
}

static bool is_control(const struct websocket *w)
{
    return w->opcode >= 8;
}

// --- the head of a frame ----------------------------------------------------

// From the first two bytes.  WEBSOCKET_MORE: nothing wrong so far.
static enum websocket_event first_bytes(struct websocket *w)
{
    unsigned length = w->head[1] & 0x7f;
    w->fin = w->head[0] & 0x80;
    w->opcode = w->head[0] & 0x0f;
    if (w->head[0] & 0x70)
        return bad(w, WEBSOCKET_PROTOCOL, "a reserved bit is set");
    if ((w->opcode > 2 && w->opcode < 8) || w->opcode > 10)
        return bad(w, WEBSOCKET_PROTOCOL, "the opcode is reserved");
    if (!(w->head[1] & 0x80))
        return bad(w, WEBSOCKET_PROTOCOL, "a client's frame is not masked");
    if (is_control(w) && (!w->fin || length > 125))
        return bad(w, WEBSOCKET_PROTOCOL,
                   "a control frame is fragmented or over 125 bytes");
    if (w->opcode == WEBSOCKET_OP_CONTINUE && !w->open)
        return bad(w, WEBSOCKET_PROTOCOL, "nothing is to be continued");
    if (!is_control(w) && w->opcode != WEBSOCKET_OP_CONTINUE && w->open)
        return bad(w, WEBSOCKET_PROTOCOL,
                   "a message begins before the last one has ended");
    if (w->opcode == WEBSOCKET_OP_BINARY && !w->allow_binary)
        return bad(w, WEBSOCKET_UNSUPPORTED, "no binary message is expected");
    w->head_need = 6 + (length == 126 ? 2 : length == 127 ? 8 : 0);
    return WEBSOCKET_MORE;
}

// Length in the shortest form that holds it (RFC 6455, section 5.2).
static bool read_length(struct websocket *w)
{
    unsigned short_length = w->head[1] & 0x7f;
    int bytes = short_length == 126 ? 2 : short_length == 127 ? 8 : 0;
    w->left = bytes ? 0 : short_length;
    for (int i = 0; i < bytes; i++)
        w->left = w->left << 8 | w->head[2 + i];
    memcpy(w->mask, w->head + 2 + bytes, 4);
    return bytes == 0 || (bytes == 2 && w->left > 125) ||
           (bytes == 8 && w->left > 65535 && w->left >> 63 == 0);
}

static enum websocket_event begin_payload(struct websocket *w)
{
    if (!read_length(w))
        return bad(w, WEBSOCKET_PROTOCOL, "a length is not in shortest form");
    w->at = 0;
    w->phase = PHASE_PAYLOAD;
    if (is_control(w)) {
        w->control_have = 0;
        return WEBSOCKET_MORE;
    }
    if (w->opcode != WEBSOCKET_OP_CONTINUE) {
        w->kind = w->opcode;
        w->fragments = 0;
        w->open = true;
    }
    if (++w->fragments > WEBSOCKET_FRAGMENTS_MAX)
        return bad(w, WEBSOCKET_POLICY, "a message has over 1024 fragments");
    if (w->left > WEBSOCKET_MESSAGE_MAX - w->message.size)
        return bad(w, WEBSOCKET_TOO_BIG, "a message is over 65536 bytes");
    return WEBSOCKET_MORE;
}

static enum websocket_event read_head(struct websocket *w, struct span *in)
{
    while (in->size > 0 && w->head_have < w->head_need) {
        w->head[w->head_have++] = *in->data++;
        in->size--;
        if (w->head_have == 2 && first_bytes(w) == WEBSOCKET_BAD)
            return WEBSOCKET_BAD;
    }
    if (w->head_have < w->head_need)
        return WEBSOCKET_MORE;
    w->head_have = 0;
    w->head_need = 2;
    return begin_payload(w);
}

// --- the payload of a frame -------------------------------------------------

static void unmask(struct websocket *w, unsigned char *to, struct span from)
{
    for (size_t i = 0; i < from.size; i++)
        to[i] = from.data[i] ^ w->mask[(w->at + i) & 3];
    w->at += from.size;
    w->left -= from.size;
}

// RFC 6455, section 7.4: codes that a client may put on the wire.
static bool close_code_legal(int code)
{
    return (code >= 1000 && code <= 1003) || (code >= 1007 && code <= 1014) ||
           (code >= 3000 && code <= 4999);
}

static enum websocket_event closed(struct websocket *w)
{
    struct span text = {w->control, w->control_have};
    int code = WEBSOCKET_NO_CODE;
    if (text.size == 1)
        return bad(w, WEBSOCKET_PROTOCOL, "a close frame of one byte");
    if (text.size >= 2) {
        code = text.data[0] << 8 | text.data[1];
        text.data += 2;
        text.size -= 2;
        if (!close_code_legal(code))
            return bad(w, WEBSOCKET_PROTOCOL, "a close code is not legal");
        if (!utf8_valid(text))
            return bad(w, WEBSOCKET_BAD_TEXT, "a close reason is not UTF-8");
    }
    w->phase = PHASE_OVER;
    w->code = code;
    w->payload = text;
    return WEBSOCKET_CLOSE;
}

// A frame is whole.
static enum websocket_event end_frame(struct websocket *w)
{
    w->phase = PHASE_HEAD;
    if (is_control(w)) {
        w->payload = (struct span){w->control, w->control_have};
        if (w->opcode == WEBSOCKET_OP_CLOSE)
            return closed(w);
        return w->opcode == WEBSOCKET_OP_PING ? WEBSOCKET_PING : WEBSOCKET_PONG;
    }
    if (!w->fin)
        return WEBSOCKET_MORE;
    w->open = false;
    w->clear = true; // by the next call
    w->payload = (struct span){w->message.data, w->message.size};
    if (w->kind == WEBSOCKET_OP_BINARY)
        return WEBSOCKET_BINARY;
    if (!utf8_valid(w->payload))
        return bad(w, WEBSOCKET_BAD_TEXT, "a text message is not UTF-8");
    return WEBSOCKET_TEXT;
}

static enum websocket_event read_payload(struct websocket *w, struct span *in)
{
    struct span part = *in;
    if (part.size > w->left)
        part.size = (size_t)w->left;
    if (is_control(w)) {
        unmask(w, w->control + w->control_have, part);
        w->control_have += part.size;
    } else if (part.size > 0) {
        unmask(w, buf_grow(&w->message, part.size), part);
    }
    in->data += part.size;
    in->size -= part.size;
    return w->left == 0 ? end_frame(w) : WEBSOCKET_MORE;
}

static void drop_message(struct websocket *w)
{
    w->clear = false;
    if (w->message.cap > WEBSOCKET_KEEP)
        buf_finish(&w->message);
    else
        buf_clear(&w->message);
}

enum websocket_event websocket_read(struct websocket *w, struct span in,
                                    size_t *used)
{
    struct span rest = in;
    enum websocket_event event = WEBSOCKET_MORE;
    if (w->clear)
        drop_message(w);
    while (event == WEBSOCKET_MORE) {
        // A frame without payload ends where its head does.
        bool idle =
            rest.size == 0 && !(w->phase == PHASE_PAYLOAD && w->left == 0);
        if (w->phase == PHASE_OVER || idle)
            break;
        event = w->phase == PHASE_HEAD ? read_head(w, &rest)
                                       : read_payload(w, &rest);
    }
    // After the end nothing counts any more.
    *used = w->phase == PHASE_OVER && event == WEBSOCKET_MORE
                ? in.size
                : in.size - rest.size;
    return event;
}

// --- frames of the server ---------------------------------------------------

size_t websocket_head(unsigned char out[WEBSOCKET_HEAD_MAX],
                      enum websocket_opcode opcode, uint64_t size)
{
    int bytes = size < 126 ? 0 : size < 65536 ? 2 : 8;
    out[0] = (unsigned char)(0x80 | (unsigned)opcode);
    out[1] = (unsigned char)(bytes == 0 ? size : bytes == 2 ? 126 : 127);
    for (int i = 0; i < bytes; i++)
        out[2 + i] = (unsigned char)(size >> (8 * (bytes - 1 - i)));
    return 2 + (size_t)bytes;
}

void websocket_frame(struct buf *out, enum websocket_opcode opcode,
                     struct span payload)
{
    unsigned char head[WEBSOCKET_HEAD_MAX];
    buf_append(out, head, websocket_head(head, opcode, payload.size));
    buf_append(out, payload.data, payload.size);
}

void websocket_frame_close(struct buf *out, int code, const char *reason)
{
    unsigned char payload[125];
    struct span text = {(const unsigned char *)(reason ? reason : ""),
                        reason ? strlen(reason) : 0};
    size_t size = 0;
    if (code != 0 && code != WEBSOCKET_NO_CODE) {
        payload[0] = (unsigned char)(code >> 8);
        payload[1] = (unsigned char)code;
        text.size = utf8_cut(text, sizeof payload - 2);
        memcpy(payload + 2, text.data, text.size);
        size = 2 + text.size;
    }
    websocket_frame(out, WEBSOCKET_OP_CLOSE, (struct span){payload, size});
}
