/* hosted PROGRAM ARGUMENT...: runs a Python program in a fork of the node host of the same launch.
 *
 * roslaunch starts `hosted` in place of that fork. `hosted` passes on the standard streams, the
 * folder, the environment and the arguments, forwards signals, and ends with the status of the
 * fork. As the launch-prefix of a <node> it leaves respawn, logs and Ctrl-C to roslaunch. It is
 * written in C because a site runs hundreds of these processes; each one needs only 0.1 MB.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

extern char **environ;

static const int PASSED_ON[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGUSR1, SIGUSR2};
static const long RETRY_NS = 20 * 1000 * 1000;
static const int TOLD_AFTER = 500; /* tries, 10 s */

static void die(const char *what)
{
    fprintf(stderr, "hosted: %s: %s\n", what, strerror(errno));
    exit(EXIT_FAILURE);
}

/* The host of a launch has the same parent as this process; see node_host/address.py. */
static socklen_t host_address(struct sockaddr_un *address)
{
    char space[64];
    ssize_t length = readlink("/proc/self/ns/pid", space, sizeof space - 1);
    if (length < 0)
        die("/proc/self/ns/pid");
    space[length] = '\0';
    memset(address, 0, sizeof *address);
    address->sun_family = AF_UNIX; /* an abstract name, so no file is made */
    int written = snprintf(address->sun_path + 1, sizeof address->sun_path - 1, "node_host/%s/%d",
                           space, (int)getppid());
    return (socklen_t)(offsetof(struct sockaddr_un, sun_path) + 1 + (size_t)written);
}

static void end_by(int number)
{
    struct rlimit no_core = {0, 0};
    sigset_t none;
    setrlimit(RLIMIT_CORE, &no_core);
    signal(number, SIG_DFL);
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
    raise(number);
    exit(128 + number);
}

/* Waits for the host, which may still start; a signal ends the wait and this process. */
static int connect_to_host(const sigset_t *signals)
{
    struct sockaddr_un address;
    socklen_t size = host_address(&address);
    struct timespec pause = {0, RETRY_NS};
    struct ucred peer;
    socklen_t peer_size = sizeof peer;
    int host = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (host < 0)
        die("socket");
    for (int tries = 1; connect(host, (struct sockaddr *)&address, size) < 0; ++tries) {
        if (errno != ECONNREFUSED && errno != EAGAIN && errno != EINTR)
            die("connection to the node host");
        if (tries == TOLD_AFTER)
            fputs("hosted: still waiting for the node host of this launch.\n", stderr);
        int number = sigtimedwait(signals, NULL, &pause);
        if (number > 0)
            end_by(number);
    }
    if (getsockopt(host, SOL_SOCKET, SO_PEERCRED, &peer, &peer_size) < 0)
        die("SO_PEERCRED");
    if (peer.uid != geteuid()) {
        fputs("hosted: the node host belongs to another user.\n", stderr);
        exit(EXIT_FAILURE);
    }
    return host;
}

static size_t joined(char *into, char *const *texts)
{
    size_t length = 0;
    for (; *texts; ++texts) {
        size_t size = strlen(*texts) + 1;
        if (into)
            memcpy(into + length, *texts, size);
        length += size;
    }
    return length;
}

/* One packet: folder, number of arguments, arguments, environment; each text ends with a zero byte. */
static void send_request(int host, int count, char **arguments)
{
    char number[16], *head[] = {get_current_dir_name(), number, NULL};
    char **parts[] = {head, arguments, environ};
    size_t total = 0, at = 0;
    if (!head[0])
        die("current folder");
    snprintf(number, sizeof number, "%d", count);
    for (int k = 0; k < 3; ++k)
        total += joined(NULL, parts[k]);
    char *text = malloc(total);
    if (!text)
        die("memory");
    for (int k = 0; k < 3; ++k)
        at += joined(text + at, parts[k]);

    int streams[3] = {0, 1, 2};
    union {
        struct cmsghdr header;
        char space[CMSG_SPACE(sizeof streams)];
    } control;
    memset(&control, 0, sizeof control);
    struct iovec content = {text, total};
    struct msghdr message = {.msg_iov = &content, .msg_iovlen = 1,
                             .msg_control = control.space, .msg_controllen = sizeof control.space};
    struct cmsghdr *header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof streams);
    memcpy(CMSG_DATA(header), streams, sizeof streams);
    if (sendmsg(host, &message, MSG_NOSIGNAL) < 0)
        die("request to the node host");
    free(text);
    free(head[0]);
}

/* Forwards signals until the fork ends. Returns the fork's status in the form of wait(2). */
static int wait_for_end(int host, int signals)
{
    struct pollfd watched[] = {{host, POLLIN, 0}, {signals, POLLIN, 0}};
    for (;;) {
        if (poll(watched, 2, -1) < 0 && errno != EINTR)
            die("poll");
        if (watched[1].revents & POLLIN) {
            struct signalfd_siginfo info;
            if (read(signals, &info, sizeof info) == (ssize_t)sizeof info) {
                unsigned char number = (unsigned char)info.ssi_signo;
                send(host, &number, 1, MSG_NOSIGNAL);
            }
        }
        if (watched[0].revents) {
            int status;
            if (recv(host, &status, sizeof status, 0) == (ssize_t)sizeof status)
                return status;
            fputs("hosted: the node host has ended, and this process with it.\n", stderr);
            exit(EXIT_FAILURE);
        }
    }
}

int main(int count, char **arguments)
{
    sigset_t signals;
    if (count < 2) {
        fputs("usage: hosted PROGRAM ARGUMENT...   (as launch-prefix of a <node>)\n", stderr);
        return 2;
    }
    sigemptyset(&signals);
    for (size_t k = 0; k < sizeof PASSED_ON / sizeof *PASSED_ON; ++k)
        sigaddset(&signals, PASSED_ON[k]);
    sigprocmask(SIG_BLOCK, &signals, NULL);
    int host = connect_to_host(&signals);
    send_request(host, count - 1, arguments + 1);
    int status = wait_for_end(host, signalfd(-1, &signals, SFD_CLOEXEC));
    if (WIFSIGNALED(status))
        end_by(WTERMSIG(status));
    return WEXITSTATUS(status);
}
