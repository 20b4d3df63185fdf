// cache.h - the directory in which results that took time are kept (fits).
// Thread: main.
#ifndef SERVER_CACHE_H
#define SERVER_CACHE_H

// $GLINT_CACHE, else $XDG_CACHE_HOME/glint, else $HOME/.cache/glint; made when
// it is not there.  NULL when there is none to be had (the caller then keeps
// nothing).  The caller frees it.
char *cache_directory(void);

#endif
