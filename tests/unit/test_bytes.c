// test_bytes.c - buffers, blobs, errors and digests.
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "protocol/digest.h"
#include "protocol/error.h"
#include "tests/check.h"

static struct span text(const char *s)
{
    return (struct span){(const unsigned char *)s, strlen(s)};
}

static void test_buf(void)
{
    struct buf b = {0};
    check_case("bytes: a buffer grows, keeps its bytes and drops its head");
    for (int i = 0; i < 5000; i++)
        buf_printf(&b, "%d,", i);
    size_t size = b.size;
    CHECK(size == 10 * 2 + 90 * 3 + 900 * 4 + 4000 * 5 && b.cap >= size);
    CHECK(memcmp(b.data, "0,1,2,3,", 8) == 0);
    CHECK(memcmp(b.data + size - 10, "4998,4999,", 10) == 0);
    buf_drop(&b, 2);
    CHECK(b.size == size - 2 && memcmp(b.data, "1,2,", 4) == 0);
    buf_drop(&b, b.size);
    CHECK(b.size == 0);
    buf_append(&b, NULL, 0);
    buf_text(&b, "");
    buf_printf(&b, "%s", "");
    CHECK(b.size == 0);
    memcpy(buf_grow(&b, 3), "abc", 3);
    buf_byte(&b, 'd');
    CHECK(b.size == 4 && memcmp(b.data, "abcd", 4) == 0);
    buf_finish(&b);
    CHECK(!b.data && b.size == 0 && b.cap == 0);
    buf_finish(&b);
}

static void test_blob(void)
{
    check_case("bytes: a blob lives until its last reference goes");
    struct blob *b = blob_from("xyz", 3);
    CHECK(b->size == 3 && memcmp(b->data, "xyz", 3) == 0);
    CHECK(blob_ref(b) == b);
    blob_unref(b);
    CHECK(memcmp(b->data, "xyz", 3) == 0);
    blob_unref(b);
    blob_unref(NULL);
    blob_unref(blob_from(NULL, 0));
}

static void test_error(void)
{
    struct error err = {0};
    check_case("error: set, prefixed, cut and cleaned");
    CHECK(!error_set(&err, "range", "a.b", "%s is %d\nnot\x7f", "x", 3));
    CHECK_STR(err.code, "range");
    CHECK_STR(err.name, "a.b");
    CHECK_STR(err.text, "x is 3 not ");
    CHECK(!error_prefix(&err, "file"));
    CHECK_STR(err.text, "file: x is 3 not ");
    CHECK(!error_set(&err, "c", NULL, "again: %s", err.text));
    CHECK_STR(err.text, "again: file: x is 3 not ");
    CHECK_STR(err.name, "");
    char longer[1000];
    memset(longer, 'l', sizeof longer);
    longer[sizeof longer - 1] = 0;
    error_set(&err, longer, longer, "%s", longer);
    CHECK(strlen(err.code) == sizeof err.code - 1);
    CHECK(strlen(err.name) == sizeof err.name - 1);
    CHECK(strlen(err.text) == sizeof err.text - 1);
    error_prefix(&err, longer);
    CHECK(strlen(err.text) == sizeof err.text - 1);
    CHECK(!error_set(NULL, "c", "n", "t") && !error_prefix(NULL, "p"));
}

// Vectors of FIPS 180 (the examples published with it).
static void test_hashes(void)
{
    static const struct {
        const char *text, *sha1, *sha256;
    } cases[] = {
        {"", "da39a3ee5e6b4b0d3255bfef95601890afd80709",
         "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"},
        {"abc", "a9993e364706816aba3e25717850c26c9cd0d89d",
         "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"},
        {"abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq",
         "84983e441c3bd26ebaae4aa1f95129e5e54670f1",
         "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1"},
    };
    unsigned char out[32];
    char hex[65];
    check_case("digest: published vectors");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        digest_sha1(text(cases[i].text), out);
        digest_hex(out, 20, hex);
        CHECK_STR(hex, cases[i].sha1);
        digest_sha256(text(cases[i].text), out);
        digest_hex(out, 32, hex);
        CHECK_STR(hex, cases[i].sha256);
    }
    struct buf million = {0};
    memset(buf_grow(&million, 1000000), 'a', 1000000);
    digest_sha1((struct span){million.data, million.size}, out);
    digest_hex(out, 20, hex);
    CHECK_STR(hex, "34aa973cd4c4daa4f61eeb2bdbad27316534016f");
    digest_sha256((struct span){million.data, million.size}, out);
    digest_hex(out, 32, hex);
    CHECK_STR(hex,
              "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc711"
              "2cd0");
    check_case("digest: pieces of any size give the same hash");
    struct digest all;
    digest_begin(&all);
    for (size_t size = 0; size < 200; size++) {
        unsigned char whole[32], parts[32];
        struct digest d;
        digest_sha256((struct span){million.data, size}, whole);
        digest_begin(&d);
        for (size_t at = 0, step = 1; at < size;
             at += step, step = step % 7 + 1)
            digest_add(&d, (struct span){million.data + at,
                                         step < size - at ? step : size - at});
        digest_end(&d, parts);
        CHECK(memcmp(whole, parts, 32) == 0);
        digest_add(&all, (struct span){whole, 32});
    }
    // Of the 200 hashes one after the other, by Python's hashlib: every place
    // at which padding can begin.
    digest_end(&all, out);
    digest_hex(out, 32, hex);
    CHECK_STR(hex, "752c007f38611cfbf5fa42cb1cea3d8e"
                   "086491c844d0cc4defd632cb81423506");
    buf_finish(&million);
}

// Vectors of RFC 4648, section 10.
static void test_base64(void)
{
    static const char *const want[] = {
        "", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"};
    char out[16];
    check_case("digest: base64");
    for (size_t n = 0; n <= 6; n++) {
        digest_base64((const unsigned char *)"foobar", n, out);
        CHECK_STR(out, want[n]);
        for (size_t size = 0; size < 8; size++)
            CHECK(digest_is_base64(text(out), size) == (size == n));
    }
    digest_base64((const unsigned char *)"\xfb\xff\xfe", 3, out);
    CHECK_STR(out, "+//+");
    static const char *const bad[] = {"Zg=a",  "Z===", "Zh==", "Zm9=", "Zg=",
                                      "Zg== ", "-_-_", "Zm 9", "Zg\n="};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        for (size_t size = 0; size < 5; size++)
            CHECK(!digest_is_base64(text(bad[i]), size));
}

int main(void)
{
    test_buf();
    test_blob();
    test_error();
    test_hashes();
    test_base64();
    return check_end();
}
