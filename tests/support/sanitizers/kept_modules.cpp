// In builds with a sanitizer, stands in for the C library's: what leaked from a library that was loaded
// at run time can only be told by name, and what is known of it left out (lsan.supp), while that
// library is loaded.
namespace ulf::test {

extern "C" int dlclose(void*) { return 0; }

}  // namespace ulf::test
