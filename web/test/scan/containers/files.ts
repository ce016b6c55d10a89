// A small tube in files of every kind that the page unpacks.  three.js brings no encoders of Draco and meshopt, so those two
// were made once: by Draco's own encoder (through DracoPy), and by meshoptimizer's.

export const RINGS = 16;
export const SEGMENTS = 12;
export const CORNERS = 6 * (RINGS - 1) * SEGMENTS;

const range = (count: number): number[] => Array.from({ length: count }, (_, index) => index);

/** Metres. */
export function place(ring: number, segment: number): [number, number, number] {
  const angle = (2 * Math.PI * segment) / SEGMENTS;
  return [0.2 * Math.cos(angle), 0.05 * ring, 0.2 * Math.sin(angle)];
}

/** Bytes. */
export const colour = (ring: number, segment: number): [number, number, number] => [10 * ring, 20 * segment, 255 - 10 * ring];

export const places = (): number[] => range(RINGS * SEGMENTS).flatMap((index) => place(Math.floor(index / SEGMENTS), index % SEGMENTS));

export const triangles = (): number[] =>
  range(RINGS - 1).flatMap((ring) =>
    range(SEGMENTS).flatMap((segment) => {
      const [a, b] = [ring * SEGMENTS + segment, ring * SEGMENTS + ((segment + 1) % SEGMENTS)];
      return [a, a + SEGMENTS, b, b, a + SEGMENTS, b + SEGMENTS];
    }),
  );

const bytes = (base64: string): Uint8Array<ArrayBuffer> => Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));

/** Places (drawn at twice their size), colours, and coordinates in a picture that is not there. */
export const dracoGlb = (): Uint8Array<ArrayBuffer> => bytes(DRACO);
/** Places and colours. */
export const meshoptGlb = (): Uint8Array<ArrayBuffer> => bytes(MESHOPT);

const DRACO =
  "Z2xURgIAAACwBgAA4AIAAEpTT057ImFzc2V0Ijp7InZlcnNpb24iOiIyLjAiLCJnZW5lcmF0b3IiOiJNdXN0ZXJtYW5uIn0sImV4dGVuc2lvbnNVc2VkIjpbIktIUl9kcmFjb19tZXNoX2NvbXByZX" +
  "NzaW9uIl0sImV4dGVuc2lvbnNSZXF1aXJlZCI6WyJLSFJfZHJhY29fbWVzaF9jb21wcmVzc2lvbiJdLCJzY2VuZXMiOlt7Im5vZGVzIjpbMF19XSwibm9kZXMiOlt7Im1lc2giOjAsInNjYWxlIjpb" +
  "MiwyLDJdfV0sIm1lc2hlcyI6W3sicHJpbWl0aXZlcyI6W3siYXR0cmlidXRlcyI6eyJQT1NJVElPTiI6MCwiQ09MT1JfMCI6MSwiVEVYQ09PUkRfMCI6Mn0sImluZGljZXMiOjMsImV4dGVuc2lvbn" +
  "MiOnsiS0hSX2RyYWNvX21lc2hfY29tcHJlc3Npb24iOnsiYnVmZmVyVmlldyI6MCwiYXR0cmlidXRlcyI6eyJQT1NJVElPTiI6MiwiQ09MT1JfMCI6MCwiVEVYQ09PUkRfMCI6MX19fX1dfV0sImFj" +
  "Y2Vzc29ycyI6W3siY29tcG9uZW50VHlwZSI6NTEyNiwiY291bnQiOjE5MiwidHlwZSI6IlZFQzMifSx7ImNvbXBvbmVudFR5cGUiOjUxMjEsImNvdW50IjoxOTIsInR5cGUiOiJWRUMzIiwibm9ybW" +
  "FsaXplZCI6dHJ1ZX0seyJjb21wb25lbnRUeXBlIjo1MTI2LCJjb3VudCI6MTkyLCJ0eXBlIjoiVkVDMiJ9LHsiY29tcG9uZW50VHlwZSI6NTEyNSwiY291bnQiOjEwODAsInR5cGUiOiJTQ0FMQVIi" +
  "fV0sImJ1ZmZlclZpZXdzIjpbeyJidWZmZXIiOjAsImJ5dGVMZW5ndGgiOjk0Nn1dLCJidWZmZXJzIjpbeyJieXRlTGVuZ3RoIjo5NDZ9XX0gtAMAAEJJTgBEUkFDTwICAQEAAADAAegCAugCAQHnAh" +
  "cBXe+6ruu6ruu6Lq2qqqqqKq2qqqqqKq2qqqqqKq2qqqqqKq2qqqqqKq2qqqqqKq2qqqqqKq2qqqqqKq2qqqqqKq2qqqqqKq2qqqqqKq2qqqqqKq2qqqqqKq2qqqqqKv8BEf8DynGA/wPKcYADAAAA" +
  "/wAAAQAAAQICAwEAAQEACQMAAgIBAwkCAQECAQEBAQPUAa09Rzg4S5EBdxz//yccHBdWlhpBEuwjQfNan1MB73XtgtZ3JftPhgAAAAD/AAAAAQEBAQS8dzkh5QaQ////////////////////////Nx" +
  "0FOQYckQH/////////////////T60EBwEC//9nHBz//3cdA/////////////////////////////////////////+jHP//////////////////////////////////////////////////////////" +
  "////////////////////////////////Pxz///////////////////////////////////////////////////////////////////////////////////////////////////////////////////" +
  "////////////////////9fHK4BBjZe8QGI+BaZ79uxxKppnq+FrZ9F7nsiweYm7/SKiv6vXKz/8aw7aNbzSClATTHnmg1rOYXEYGKcdJO5ZgtpGtRx8vYnLO961p0XZ30sYHh7R5sQ94U9V30sYHiR" +
  "XGlr5kasg7ls3daJE8OmHqdDncd1cPJGwTvJJUMieCuRr6IjCJddtnadhLPyS9Jg0rpP+hfV0K/jTvceGpdufRrhKwjII5oW7CHWF9fK/f+MAAAAAP8/AADNzEy+AAAAAM3MTL4AAEA/DgUBAQEF/R" +
  "mlHCz/I1UD/0dVA1esK60B////My0EAyUT//87LCz//////////4Ms////OywvLP//////Dyz//////////4Ms/////////+sskyz//////////4Msq9QLVHLg7bglOmiu9ykoUJCbdVOugrAY4lb0" +
  "B5g1aTjkCPoDf9MQHfr58DQabg4yrAOgr8zB1KPfP+gPL5cmAWQXJS6rYgij3Cg4ZrrLs0xT0NmNz8zAaDtWTbpAFiAC8WEvYP3NzxHZXLsCbq4hlwJ1TTBvQ4C+AAAAJBBAXS6hHTEkQckBvosMPU" +
  "ZAAAAAAP8PAAAAAAAAAAAAAAAAcD8MAAA=";

const MESHOPT =
  "Z2xURgIAAAA0DgAAoAQAAEpTT057ImFzc2V0Ijp7InZlcnNpb24iOiIyLjAifSwiZXh0ZW5zaW9uc1VzZWQiOlsiRVhUX21lc2hvcHRfY29tcHJlc3Npb24iXSwiZXh0ZW5zaW9uc1JlcXVpcmVkIj" +
  "pbIkVYVF9tZXNob3B0X2NvbXByZXNzaW9uIl0sInNjZW5lcyI6W3sibm9kZXMiOlswXX1dLCJub2RlcyI6W3sibWVzaCI6MH1dLCJtZXNoZXMiOlt7InByaW1pdGl2ZXMiOlt7ImF0dHJpYnV0ZXMi" +
  "OnsiUE9TSVRJT04iOjAsIkNPTE9SXzAiOjF9LCJpbmRpY2VzIjoyfV19XSwiYWNjZXNzb3JzIjpbeyJidWZmZXJWaWV3IjowLCJjb21wb25lbnRUeXBlIjo1MTI2LCJjb3VudCI6MTkyLCJ0eXBlIj" +
  "oiVkVDMyJ9LHsiYnVmZmVyVmlldyI6MSwiY29tcG9uZW50VHlwZSI6NTEyMSwibm9ybWFsaXplZCI6dHJ1ZSwiY291bnQiOjE5MiwidHlwZSI6IlZFQzQifSx7ImJ1ZmZlclZpZXciOjIsImNvbXBv" +
  "bmVudFR5cGUiOjUxMjUsImNvdW50IjoxMDgwLCJ0eXBlIjoiU0NBTEFSIn1dLCJidWZmZXJWaWV3cyI6W3siYnVmZmVyIjoxLCJieXRlT2Zmc2V0IjowLCJieXRlTGVuZ3RoIjoyMzA0LCJieXRlU3" +
  "RyaWRlIjoxMiwiZXh0ZW5zaW9ucyI6eyJFWFRfbWVzaG9wdF9jb21wcmVzc2lvbiI6eyJidWZmZXIiOjAsImJ5dGVPZmZzZXQiOjAsImJ5dGVMZW5ndGgiOjE2MzYsImJ5dGVTdHJpZGUiOjEyLCJj" +
  "b3VudCI6MTkyLCJtb2RlIjoiQVRUUklCVVRFUyJ9fX0seyJidWZmZXIiOjEsImJ5dGVPZmZzZXQiOjIzMDQsImJ5dGVMZW5ndGgiOjc2OCwiYnl0ZVN0cmlkZSI6NCwiZXh0ZW5zaW9ucyI6eyJFWF" +
  "RfbWVzaG9wdF9jb21wcmVzc2lvbiI6eyJidWZmZXIiOjAsImJ5dGVPZmZzZXQiOjE2MzYsImJ5dGVMZW5ndGgiOjM2MywiYnl0ZVN0cmlkZSI6NCwiY291bnQiOjE5MiwibW9kZSI6IkFUVFJJQlVU" +
  "RVMifX19LHsiYnVmZmVyIjoxLCJieXRlT2Zmc2V0IjozMDcyLCJieXRlTGVuZ3RoIjo0MzIwLCJleHRlbnNpb25zIjp7IkVYVF9tZXNob3B0X2NvbXByZXNzaW9uIjp7ImJ1ZmZlciI6MCwiYnl0ZU" +
  "9mZnNldCI6MjAwMCwiYnl0ZUxlbmd0aCI6NDIyLCJieXRlU3RyaWRlIjo0LCJjb3VudCI6MTA4MCwibW9kZSI6IlRSSUFOR0xFUyJ9fX1dLCJidWZmZXJzIjpbeyJieXRlTGVuZ3RoIjoyNDI0fSx7" +
  "ImJ5dGVMZW5ndGgiOjczOTIsImV4dGVuc2lvbnMiOnsiRVhUX21lc2hvcHRfY29tcHJlc3Npb24iOnsiZmFsbGJhY2siOnRydWV9fX1dfXgJAABCSU4AoP///wBBQvv8QUJBQt7dQUJBQvv8QUJBQt" +
  "7dQUJBQvv8QUJBQt7dQUJBQvv8QUJBQt7dQUJBQvv8QUJBQt7dQUJBQvv8QUJBQt7dQUJBQvv8QUJBQt7dQUJBQvv8QUJBQt7dQUJBQvv8QUJBQt7dQUJBQvv8QUJBQt7dQUJBQvv8QUJBQt7dQUJB" +
  "Qvv8QUJBQt7dQUJBQvv8QUJBQt7dQUJBQvv8QUJBQt7dQUJBQvv8QUJBQt7dQUJBQvv8QUJBQt7dQf///wDf4Dg33+Df4Lu83+Df4Dg33+Df4Lu83+Df4Dg33+Df4Lu83+Df4Dg33+Df4Lu83+Df4D" +
  "g33+Df4Lu83+Df4Dg33+Df4Lu83+Df4Dg33+Df4Lu83+Df4Dg33+Df4Lu83+Df4Dg33+Df4Lu83+Df4Dg33+Df4Lu83+Df4Dg33+Df4Lu83+Df4Dg33+Df4Lu83+Df4Dg33+Df4Lu83+Df4Dg33+Df" +
  "4Lu83+Df4Dg33+Df4Lu83+Df4Dg33+Df4Lu83////wA1ydXWyjY1ybq5yjY1ydXWyjY1ybq5yjY1ydXWyjY1ybq5yjY1ydXWyjY1ybq5yjY1ydXWyjY1ybq5yjY1ydXWyjY1ybq5yjY1ydXWyjY1yb" +
  "q5yjY1ydXWyjY1ybq5yjY1ydXWyjY1ybq5yjY1ydXWyjY1ybq5yjY1ydXWyjY1ybq5yjY1ydXWyjY1ybq5yjY1ydXWyjY1ybq5yjY1ydXWyjY1ybq5yjY1ydXWyjY1ybq5yjY1ydXWyjY1ybq5ylVV" +
  "VQfgfgczyzHNM+B+B+DLMc0zy34H4H4xzTPLMc0H4H4HM8sxzTPgfgfgyzHNM8t+B+B+Mc0zyzHNB+B+BzPLMc0z4H4H4MsxzTPLfgfgfjHNM8sxzQfgfgczyzHNM+B+B+DLMc0zy34H4H4xzTPLMc" +
  "1RVVUAAADAZQDAAABlwAAAwGZmAADAAMsAwAAAzcAAAMDLzQAAwADLAMAAAGXAAADAZWcAAMAAZQDAAABlUVVVAAAAwGcAwAAAZcAAAMBmaAAAwADNAMAAAMvAAADAzcsAAMAAywDAAABnwAAAwGVl" +
  "AADAAGUAwAAAZVVVVQAAAMCYAADAAP8AwAAAmsAAAMBmaAAAwAAyAMAAADTAAADAMjQAAMAANADAAAAYwAAAwBoaAADAABoAwAAAGhFAAAAAAMB6AIAAAAAAgAD///8AZUFCQUL7/EFCQUJmZUFCQU" +
  "L7/EFCQUJmZUFCQUL7/EFCQUJmZUFCQUL7/EFCQUJmZUFCQUL7/EFCQUJmZUFCQUL7/EFCQUJmZUFCQUL7/EFCQUJmZUFCQUL7/EFCQUJmZUFCQUL7/EFCQUJmZUFCQUL7/EFCQUJmZUFCQUL7/EFC" +
  "QUJmZUFCQUL7/EFCQUJmZUFCQUL7/EFCQUJmZUFCQUL7/EFCQUJmZUFCQUL7/EFCQUJmZUFCQUL7/EFCQUL///8AZ9/g3+A4N9/g3+BoZ9/g3+A4N9/g3+BoZ9/g3+A4N9/g3+BoZ9/g3+A4N9/g3+" +
  "BoZ9/g3+A4N9/g3+BoZ9/g3+A4N9/g3+BoZ9/g3+A4N9/g3+BoZ9/g3+A4N9/g3+BoZ9/g3+A4N9/g3+BoZ9/g3+A4N9/g3+BoZ9/g3+A4N9/g3+BoZ9/g3+A4N9/g3+BoZ9/g3+A4N9/g3+BoZ9/g" +
  "3+A4N9/g3+BoZ9/g3+A4N9/g3+BoZ9/g3+A4N9/g3+D///8AZ8o2NckqKco2NcloZ8o2NckqKco2NcloZ8o2NckqKco2NcloZ8o2NckqKco2NcloZ8o2NckqKco2NcloZ8o2NckqKco2NcloZ8o2Nc" +
  "kqKco2NcloZ8o2NckqKco2NcloZ8o2NckqKco2NcloZ8o2NckqKco2NcloZ8o2NckqKco2NcloZ8o2NckqKco2NcloZ8o2NckqKco2NcloZ8o2NckqKco2NcloZ8o2NckqKco2NcloZ8o2NckqKco2" +
  "NclVVVU4H4H4ejPLhnofgfgfM8uGejPLgfgfgYZ6M8v4H4H4hnozy4Z6H4H4HzPLhnozy4H4H4GGejPL+B+B+IZ6M8uGeh+B+B8zy4Z6M8uB+B+Bhnozy/gfgfiGejPLhnofgfgfM8uGejPLgfgfgY" +
  "Z6M8sAAAAAAAAAAAAAAAAAAAAAAAAAAM3MTD4AAAAAAAAAAKBVVVUAAADAFAAAwAAUAMAAABTAAADAFBQAAMAAFADAAAAUwAAAwBQUAADAABQAwAAAFMAAAMAUFAAAwAAUAMAAABT///8AKCgoKCgo" +
  "KCgoKChIKCgoKCgoKCgoKChIKCgoKCgoKCgoKChIKCgoKCgoKCgoKChIKCgoKCgoKCgoKChIKCgoKCgoKCgoKChIKCgoKCgoKCgoKChIKCgoKCgoKCgoKChIKCgoKCgoKCgoKChIKCgoKCgoKCgoKC" +
  "hIKCgoKCgoKCgoKChIKCgoKCgoKCgoKChIKCgoKCgoKCgoKChIKCgoKCgoKCgoKChIKCgoKCgoKCgoKChIKCgoKCgoKCgoKChVVVUAAADAEwAAwAATAMAAABPAAADAExMAAMAAEwDAAAATwAAAwBMT" +
  "AADAABMAwAAAE8AAAMATEwAAwAATAMAAABMAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAD//wDh/h4AHgAeAB4AHgAeAB4AHgAeAB4AHg8Q/g4AHgAeAB4AHgAeAB4AHgAeAB4AHg8Q/g" +
  "4AHgAeAB4AHgAeAB4AHgAeAB4AHg8Q/g4AHgAeAB4AHgAeAB4AHgAeAB4AHg8Q/g4AHgAeAB4AHgAeAB4AHgAeAB4AHg8Q/g4AHgAeAB4AHgAeAB4AHgAeAB4AHg8Q/g4AHgAeAB4AHgAeAB4AHgAe" +
  "AB4AHg8Q/g4AHgAeAB4AHgAeAB4AHgAeAB4AHg8Q/g4AHgAeAB4AHgAeAB4AHgAeAB4AHg8Q/g4AHgAeAB4AHgAeAB4AHgAeAB4AHg8Q/g4AHgAeAB4AHgAeAB4AHgAeAB4AHg8Q/g4AHgAeAB4AHg" +
  "AeAB4AHgAeAB4AHg8Q/g4AHgAeAB4AHgAeAB4AHgAeAB4AHg8Q/g4AHgAeAB4AHgAeAB4AHgAeAB4AHg8Q/g4AHgAeAB4AHgAeAB4AHgAeAB4AHg8Q8BgtHzAtHzAtHzAtHzAtHzAtHzAtHzAtHzAt" +
  "HzAtHzAtHzAtHzAtHzAtHzAtAHaHVmd4qYZliWiYAWkAAAAA";
